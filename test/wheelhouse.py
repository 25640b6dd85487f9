"""Stand-ins for what the set-up installs, as wheels in a folder: real pip, no network."""

from __future__ import annotations

import zipfile
from collections.abc import Mapping
from pathlib import Path

CMAKE = """set(inc "/opt/python/cp311-cp311/include/python3.11;
/opt/python/cp311-cp311/lib/python3.11/site-packages/numpy/_core/include")
"""

NUMPY = "def get_include():\n    return '/numpy/include'\n"

#: builds nothing, but leaves what a build leaves; the environment says how it misbehaves
COLCON = """
import os, pathlib, sys, time

def main():
    root = pathlib.Path(sys.argv[sys.argv.index("--base-paths") + 1]).parent
    with (root / "builds").open("a") as count:
        count.write(os.environ.get("MAKEFLAGS", "") + "\\n")
    time.sleep(float(os.environ.get("FAKE_SLEEP", "0")))
    if "FAKE_ERROR" in os.environ:
        print("all is well so far")
        print("CMake Error at CMakeLists.txt:3: " + os.environ["FAKE_ERROR"])
        print("that is all")
        return 1
    prefixes = []
    for manifest in sorted(root.glob("src/*/package.xml")):
        name = manifest.parent.name
        share = root / "install" / name / "share" / name
        share.mkdir(parents=True, exist_ok=True)
        (share / "package.xml").write_text(manifest.read_text())
        prefixes.append(str(root / "install" / name))
        program = root / "install" / name / "lib" / name / "node"
        program.parent.mkdir(parents=True, exist_ok=True)
        python = f'"{sys.executable}"' if " " in sys.executable else sys.executable
        program.write_text(f"#!{python}\\nimport sys\\nprint(sys.prefix, sys.argv[1:])\\n")
        program.chmod(0o755)
    first = {"AMENT_PREFIX_PATH": ":".join(prefixes), "PYTHONPATH": prefixes[0] + "/python"}
    lines = [f"export {k}='{v}'" + "${" + k + ":+:$" + k + "}" for k, v in first.items()]
    (root / "install" / "local_setup.bash").write_text("\\n".join(lines) + "\\n")
    return 0
"""


def fill(folder: Path) -> None:
    """Write the wheels of the stand-ins."""
    folder.mkdir(parents=True, exist_ok=True)
    _wheel(folder, "numpy", {"numpy/__init__.py": NUMPY})
    _wheel(folder, "ros_fake", {"ros_fake-1.0.data/data/share/fake/cmake/fake.cmake": CMAKE})
    entry = "[console_scripts]\ncolcon = colcon_fake:main\n"
    script = {"colcon_fake-1.0.dist-info/entry_points.txt": entry}
    _wheel(folder, "colcon_fake", {"colcon_fake/__init__.py": COLCON} | script)


def _wheel(folder: Path, name: str, files: Mapping[str, str]) -> None:
    info = f"{name}-1.0.dist-info"
    described = {
        f"{info}/METADATA": f"Metadata-Version: 2.1\nName: {name}\nVersion: 1.0\n",
        f"{info}/WHEEL": "Wheel-Version: 1.0\nRoot-Is-Purelib: true\nTag: py3-none-any\n",
    }
    everything = {**files, **described}
    record = "".join(f"{path},,\n" for path in [*everything, f"{info}/RECORD"])
    with zipfile.ZipFile(folder / f"{name}-1.0-py3-none-any.whl", "w") as wheel:
        for path, text in {**everything, f"{info}/RECORD": record}.items():
            wheel.writestr(path, text)
