"""Make a release from a clean clone: check, build, check what was built, tag.

``python3 tools/release.py VERSION OUT [--skip-tests] [--tag]``: every file must name VERSION and CHANGELOG.md must hold
its section; then every test runs in a fresh clone, the wheels are built from it into OUT, installed into an empty
environment, and imported there, and the site is built into OUT/site, without a warning. ``--tag`` puts ``vVERSION`` on
the commit last, so that no tag is on what failed.
Exit status: 0 done, 1 a step failed, 2 the release is not ready (one line says where).
"""

from __future__ import annotations

import argparse
import re
import subprocess
import sys
import tempfile
import venv
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
VERSIONS = {
    "CITATION.cff": r"^version: (\S+)$",
    "codemeta.json": r'"version": "([^"]+)"',
    "src/er_models/er_models/version.py": r'__version__ = "([^"]+)"',
}
"""Where the version stands, besides every package.xml: file, pattern."""


def stated(root: Path) -> dict[str, str]:
    """The version that each file states; empty where a file states none."""
    places = dict(VERSIONS)
    for path in sorted(root.glob("src/*/package.xml")):
        places[str(path.relative_to(root))] = r"<version>([^<]+)</version>"
    found = {}
    for name, pattern in places.items():
        match = re.search(pattern, (root / name).read_text(encoding="utf-8"), re.M)
        found[name] = match[1] if match else ""
    return found


def not_ready(root: Path, version: str) -> list[str]:
    """What stands in the way of a release of `root` as `version`, a line each."""
    wrong = [
        f"{name}: version: expected {version}, found {said or 'none'}"
        for name, said in stated(root).items()
        if said != version
    ]
    if f"\n## [{version}] - " not in (root / "CHANGELOG.md").read_text(encoding="utf-8"):
        wrong.append(f"CHANGELOG.md: expected a section '## [{version}] - DATE', found none")
    return wrong


def run(*words: str | Path, cwd: Path) -> None:
    """Run a step and show what it says; CalledProcessError where it fails."""
    print("release:", *words, flush=True)
    subprocess.run([str(word) for word in words], cwd=cwd, check=True)


def build(clone: Path, out: Path) -> None:
    """Wheels of the pure packages of `clone` into `out`, installed together in an empty environment and imported."""
    pure = [path.parent for path in sorted(clone.glob("src/*/pyproject.toml"))]
    out.mkdir(parents=True, exist_ok=True)
    python = clone / ".release" / "bin" / "python"
    venv.create(python.parent.parent, with_pip=True)
    run(python, "-m", "pip", "wheel", "-q", "--no-deps", "-w", out, *pure, cwd=clone)
    run(python, "-m", "pip", "install", "-q", *sorted(out.glob("er_*.whl")), cwd=clone)
    names = [path.name for path in pure]
    run(python, "-c", "import " + ", ".join(names), cwd=out)


def site(clone: Path, out: Path) -> None:
    """The documents as a web site; any warning, a dead link among them, is a failure."""
    run(clone / "er", "exec", "python", "tools/docs_site.py", out, cwd=clone)
    if not (out / "index.html").is_file():
        raise subprocess.CalledProcessError(1, "docs_site.py")


def main(argv: list[str]) -> int:
    """Run the steps in order; returns the exit status."""
    parser = argparse.ArgumentParser(prog="release.py", description=__doc__)
    parser.add_argument("version")
    parser.add_argument("out", type=Path, help="folder for wheels and site")
    parser.add_argument("--skip-tests", action="store_true", help="where they have just run")
    parser.add_argument("--tag", action="store_true", help="tag the commit when all is well")
    chosen = parser.parse_args(argv)
    changed = subprocess.run(
        ["git", "status", "--porcelain"], cwd=ROOT, capture_output=True, text=True, check=True
    ).stdout
    wrong = not_ready(ROOT, chosen.version)
    if changed:
        wrong.append(f"expected a clean checkout, found changes: {changed.split()[1]} ...")
    if wrong:
        print(*(f"release: {line}" for line in wrong), sep="\n", file=sys.stderr)
        return 2
    try:
        with tempfile.TemporaryDirectory() as folder:
            clone = Path(folder) / "clone"
            run("git", "clone", "-q", ROOT, clone, cwd=ROOT)
            if not chosen.skip_tests:
                run(clone / "er", "test", "--all", cwd=clone)
            build(clone, chosen.out.resolve())
            site(clone, chosen.out.resolve() / "site")
        if chosen.tag:
            run("git", "tag", "-a", f"v{chosen.version}", "-m", chosen.version, cwd=ROOT)
    except subprocess.CalledProcessError as error:
        print(f"release: a step failed with status {error.returncode}", file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
