"""Commands that look at a graph: what a user can cause is one line with the status of bad usage."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

pytest.importorskip("rclpy")

from er_bringup.ros_checks import Observation

from er_bringup import doctor, ros_inject, ros_listen


@pytest.mark.parametrize(
    ("main", "argv"),
    [
        (doctor.main, ["er doctor", "--seconds", "0.1"]),
        (ros_inject.main, ["er inject", "pwm/command", "ok"]),
    ],
)
def test_a_place_for_logs_that_cannot_be_written_is_one_line(
    main: Callable[[], None],
    argv: list[str],
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.setattr("sys.argv", argv)
    monkeypatch.setenv("ROS_LOG_DIR", "/dev/null/logs")
    with pytest.raises(SystemExit) as ended:
        main()
    assert ended.value.code == 2
    expected = "ROS_LOG_DIR: expected a folder that can be written, found /dev/null/logs"
    assert capsys.readouterr().err == f"{argv[0]}: {expected}\n"


def test_a_result_that_cannot_be_written_is_bad_usage_not_a_sick_graph(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    monkeypatch.setattr(ros_listen, "observe", lambda *_: [Observation("", 0.1)])
    (tmp_path / "file").touch()
    monkeypatch.setattr("sys.argv", ["er doctor", "--json", str(tmp_path / "file/result.json")])
    with pytest.raises(SystemExit) as ended:
        doctor.main()
    assert ended.value.code == 2
    said = capsys.readouterr().err
    assert said.startswith("er doctor: ")
    assert said.count("\n") == 1
