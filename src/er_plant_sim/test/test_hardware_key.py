"""The key file, and that a device over UDP answers who has the key."""

from __future__ import annotations

import shutil
import socket
import stat
import subprocess
from dataclasses import replace
from pathlib import Path

import pytest
from er_models.errors import InputError
from er_plant_sim.hardware import bridge, device, key_file
from er_plant_sim.hardware.device import Device
from er_plant_sim.hardware.emulator import Emulator
from er_plant_sim.hardware.impair import Wire
from er_plant_sim.hardware.link import UdpLink
from test_hardware_bridge import CALIBRATION, MS, RIG, host


def test_a_key_is_made_once_for_its_owner_alone(tmp_path: Path) -> None:
    path = tmp_path / "new" / "wire.key"
    assert key_file.make(path)
    key = key_file.read(path)
    assert len(key) == 32
    assert stat.S_IMODE(path.stat().st_mode) == 0o600
    assert not key_file.make(path)
    assert key_file.read(path) == key
    assert list(path.parent.iterdir()) == [path]


@pytest.mark.parametrize(
    ("text", "mode", "words"),
    [
        ("ab" * 32, 0o640, r"only its owner can read \(chmod 600\), found mode 0640"),
        ("ab" * 32, 0o602, "found mode 0602"),
        ("ab" * 31, 0o600, "64 hexadecimal digits, found 62"),
        ("", 0o600, "64 hexadecimal digits"),
        (None, 0o600, "a key .er run er_plant_sim wire_key., found No such file"),
    ],
)
def test_a_file_that_is_no_safe_key_is_refused(
    tmp_path: Path, text: str | None, mode: int, words: str
) -> None:
    path = tmp_path / "key"
    if text is not None:
        path.write_text(text)
        path.chmod(mode)
    with pytest.raises(InputError, match=words) as caught:
        key_file.read(path)
    assert "ab" * 8 not in str(caught.value)


def test_udp_has_a_key_by_itself_and_a_serial_port_has_one_if_asked(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setenv("XDG_CONFIG_HOME", str(tmp_path))
    key, note = key_file.key_of("", "udp")
    assert (len(key), key_file.key_of("", "udp")) == (32, (key, ""))
    assert f"made the key {tmp_path / 'er' / 'wire.key'}" in note
    for text, kind in (("none", "udp"), ("", "serial"), ("", "pty")):
        plain, note = key_file.key_of(text, kind)
        assert (plain, "without authentication" in note) == (b"", True)
    assert key_file.key_of(str(key_file.default()), "serial") == (key, "")
    with pytest.raises(InputError, match="No such file"):
        key_file.key_of(str(tmp_path / "gone"), "udp")


def test_the_command_makes_a_key_and_prints_it_as_c(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path = tmp_path / "key"
    key_file.main([str(path)])
    assert str(path) in capsys.readouterr().out
    with pytest.raises(SystemExit) as ended:
        key_file.main([str(path)])
    assert ended.value.code == 2
    assert "a file that is not there yet" in capsys.readouterr().err
    key_file.main(["--c", str(path)])
    code = capsys.readouterr().out
    assert [int(each, 16) for each in code.split("{")[1].split("}")[0].split(",")] == list(
        key_file.read(path)
    )
    compiler = shutil.which("cc")
    if compiler:
        source = tmp_path / "key.c"
        source.write_text(
            f"#include <stdint.h>\n{code}int first(void) {{ return er_wire_key[0]; }}\n"
        )
        strict = [compiler, "-std=c99", "-Wall", "-Werror", "-fsyntax-only", str(source)]
        subprocess.run(strict, check=True)


def test_a_device_over_udp_sends_its_samples_to_who_opened_the_session() -> None:
    """A recorded call is answered where it came from; the samples stay with the host."""
    key, p = bytes(range(32)), replace(host(), key=bytes(range(32)))
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as free:
        free.bind(("127.0.0.1", 0))
        port = free.getsockname()[1]
    link = UdpLink("127.0.0.1", port, listen=True, follow=False)
    emulator = Emulator(Device(RIG, CALIBRATION, 1, key, b"d" * 16), link, Wire(), 0.0)
    state, there = device.start(emulator.device), device.start(emulator.device)
    ours, forger = UdpLink("127.0.0.1", port), UdpLink("127.0.0.1", port)
    us, tape, now = bridge.start(p, 0, seed=b"h" * 16), list[bytes](), 10**9
    for _ in range(4):
        now += 100 * MS
        us, said = bridge.on_time(p, us, now)
        out = said.data
        while out:
            ours.write(out)
            tape.append(out)
            there, answer = emulator._heard(there, link.read(1.0), link.sender)
            link.write(answer, link.sender)
            us, said = bridge.on_bytes(p, us, ours.read(0.1), now)
            out = said.data
    peer = link.peer
    assert peer is not None
    assert us.hello is not None
    for data in (*tape, b"noise"):
        forger.write(data)
        heard = link.read(1.0)
        assert heard == data
        there, answer = emulator._heard(there, heard, link.sender)
        if answer:
            link.write(answer, link.sender)
            assert forger.read(1.0) == answer
            assert len(answer) <= len(data) + 8
        assert link.peer == peer
    assert state.callee.sessions < there.callee.sessions == 1
    link.write(b"sample")
    assert ours.read(1.0) == b"sample"
    for each in (ours, forger, link):
        each.close()
