"""Settings of the middleware: ours, unless the user has others."""

from pathlib import Path
from xml.etree import ElementTree

from er_ros_common import dds


def test_the_users_own_settings_win(tmp_path: Path) -> None:
    for env in ({dds.VARIABLE: "mine.xml"}, {}):
        given = dict(env)
        (tmp_path / dds.OWN).write_text("")
        dds.settle(given, tmp_path)
        assert given == env
    (tmp_path / dds.OWN).unlink()
    given = {}
    dds.settle(given, tmp_path)
    file = Path(given[dds.VARIABLE])
    (period,) = ElementTree.parse(file).findall(".//{*}heartbeatPeriod")
    assert [(part.tag.rpartition("}")[2], part.text) for part in period] == [
        ("nanosec", "100000000")
    ]
