"""Style and types of the whole repository, as one test each."""

import re
import subprocess
import sys
from pathlib import Path, PurePath

ROOT = Path(__file__).resolve().parents[1]
TYPED = (
    "src/er_models/er_models",
    "src/er_common/er_common",
    "src/er_records/er_records",
    "src/er_model_lab/er_model_lab",
    "src/er_observers/er_observers",
    "src/er_plant_sim/er_plant_sim",
    "src/er_ftc_controller/er_ftc_controller",
    "src/er_ros_common/er_ros_common",
    "src/er_bringup/er_bringup",
    "src/er_studies/er_studies",
)


def run(*command):
    return subprocess.run(
        [sys.executable, "-m", *command], cwd=ROOT, capture_output=True, text=True, check=False
    )


def test_ruff_finds_nothing():
    result = run("ruff", "check", "--no-cache", "--output-format", "concise", ".")
    assert result.returncode == 0, result.stdout[-4000:]


def test_the_formatter_has_nothing_to_do():
    result = run("ruff", "format", "--no-cache", "--check", ".")
    assert result.returncode == 0, result.stdout[-2000:]


def test_mypy_finds_nothing():
    result = run("mypy", "--no-error-summary", "--cache-dir", str(ROOT / ".mypy_cache"), *TYPED)
    assert result.returncode == 0, result.stdout[-6000:]


def test_the_project_names_no_machine():
    """No path of a machine and no package host in anything that is kept."""
    found = subprocess.run(
        ["git", "grep", "-nIE", r"(^|[^a-z])/(work|root)/|https?://(pypi|files\.pythonhosted)", "--", ".",
         ":!LICENSE", ":!test/test_style.py"],
        cwd=ROOT, capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert found.stdout == ""


def test_nothing_has_a_place_that_others_can_foretell():
    """In the folder of temporary files whoever is on the machine can put something there first."""
    found = subprocess.run(
        ["git", "grep", "-nIE", r"(^|[^a-z_.])/tmp\b|gettempdir|tempfile\.mktemp", "--", ".",
         ":!LICENSE", ":!test/test_style.py"],
        cwd=ROOT, capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert found.stdout == ""


def kept_files():
    """Names of all files that are kept."""
    listed = subprocess.run(
        ["git", "ls-files"], cwd=ROOT, capture_output=True, text=True, check=True
    )
    return listed.stdout.splitlines()


TOP = {
    ".ci", ".devcontainer", ".dockerignore", ".github", ".gitignore", ".pre-commit-config.yaml", "ARCHITECTURE.md",
    "CHANGELOG.md", "CITATION.cff", "CONTRIBUTING.md", "Dockerfile", "LICENSE", "README.md", "SECURITY.md",
    "codemeta.json", "config", "docs", "er", "examples", "pyproject.toml", "requirements", "src", "test", "tools",
}  # fmt: skip


def test_the_top_level_holds_what_belongs_there():
    """A report that a command wrote beside the sources was once committed with them."""
    assert {name.split("/")[0] for name in kept_files()} == TOP


EXAMPLES = {"crosstalk.py", "my_orifice.py", "one_gain.py"}
"""Files that CONTRIBUTING.md writes."""
NAMED = re.compile(r"`([\w/]+\.py)`")
"""A file of ours in a text: its name, or the end of its path."""


def test_files_that_a_text_names_are_there():
    """A bare name in a package's file is of that package; in a document, or with a folder, it is any of ours."""
    kept = kept_files()
    missing = []
    for path in kept:
        if not path.endswith((".py", ".md")):
            continue
        home = "/".join(path.split("/")[:2]) if path.startswith("src/") else ""
        for name in NAMED.findall((ROOT / path).read_text(encoding="utf-8")):
            near = home if "/" not in name else ""
            there = any(f"/{each}".endswith(f"/{name}") and each.startswith(near) for each in kept)
            if not there and PurePath(name).name not in EXAMPLES:
                missing.append(f"{path}: {name}")
    assert missing == []


LINK = re.compile(r"\]\(([^)#\s]*)(#[^)\s]*)?\)")
"""The target of a link in a document, and the heading there."""


def headings(text):
    """Anchors of a document's headings: lower case, punctuation gone, blanks as hyphens."""
    found = re.findall(r"^#+ +(.*)$", text, re.M)
    return {re.sub(r"[^\w\- ]", "", each.lower()).replace(" ", "-") for each in found}


def test_no_link_is_dead():
    """A link to a file of ours leads to a file, and to a heading that this file has."""
    dead = []
    for name in kept_files():
        path = ROOT / name
        if not name.endswith(".md"):
            continue
        for target, anchor in LINK.findall(path.read_text(encoding="utf-8")):
            end = path.parent / target if target else path
            if "://" in target:
                continue
            if not end.exists() or (
                anchor and end.suffix == ".md" and anchor[1:] not in headings(end.read_text())
            ):
                dead.append(f"{name}: {target}{anchor}")
    assert dead == []
