"""A fleet whose disk is full, whose workers die, whose data are bad: with real disks, processes and signals."""

from __future__ import annotations

import json
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from test_fleet import record

FULL = """
import json, os, sys
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from pathlib import Path

place, data = map(Path, sys.argv[1:])
for folder in ("out", "tmp"):
    (place / folder).mkdir()
    os.system(f"mount -t tmpfs -o size=600k none {place / folder}")
os.environ["TMPDIR"] = str(place / "tmp")
import er_model_lab as lab


def filled(stage, done, *_):
    if done == 2:
        for folder in ("out", "tmp"):
            with suppress(OSError), (place / folder / "filler").open("wb", buffering=0) as file:
                while True:
                    file.write(bytes(512))


asked = dict(out=place / "out" / "fleet.parquet", search=False)
with ThreadPoolExecutor(1) as pool:
    found = lab.fleet(data, lab.load_model("inove_guo"), executor=pool, progress=filled, **asked)
    print(json.dumps({"errors": [*map(str, found.errors)], **found.to_dict()}))
    for folder in ("out", "tmp"):
        (place / folder / "filler").unlink()
    again = lab.fleet(data, lab.load_model("inove_guo"), executor=pool, resume=True, **asked)
    print(json.dumps({"errors": [*map(str, again.errors)], **again.to_dict()}))
"""


def mounts() -> bool:
    """Whether this user may mount a file system of his own."""
    if shutil.which("unshare") is None:
        return False
    tried = ["unshare", "-Urm", "mount", "-t", "tmpfs", "none", "/mnt"]
    return subprocess.run(tried, capture_output=True, check=False).returncode == 0


@pytest.mark.slow
@pytest.mark.skipif(not mounts(), reason="no file system of one's own")
def test_a_disk_that_is_really_full_ends_no_run(tmp_path: Path) -> None:
    """Results, tables and temporary files have no room left from the second recording on."""
    for k in range(5):
        record(tmp_path / "data" / "u" / f"{k}.parquet", k, seconds=3.0)
    (tmp_path / "full.py").write_text(FULL)
    words = ["unshare", "-Urm", sys.executable, tmp_path / "full.py", tmp_path, tmp_path / "data"]
    ended = subprocess.run(words, capture_output=True, text=True, timeout=300, check=False)
    assert ended.returncode == 0, ended.stderr
    first, again = map(json.loads, ended.stdout.splitlines())
    assert first["statuses"] == again["statuses"] == {"used": 5}
    out = tmp_path / "out"
    for error, name in zip(first["errors"], ("fleet", "fleet.recordings"), strict=True):
        assert error.startswith(
            f"{out}/{name}.parquet: --out: expected a place that can be written"
        )
        assert error.endswith("No space left on device")
    said = "\n".join(first["notes"])
    assert f"{out}/fleet.results could not be written (database or disk is full)" in said
    assert "rows stayed in memory" in said
    assert (first["tables"], first["complete"], again["complete"]) == ({}, False, True)
    assert 1 <= again["reused"] < 5
    assert again["tables"].keys() == {"units", "recordings"}
