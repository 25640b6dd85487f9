"""The documents as a web site that needs no network: ``./er exec python tools/docs_site.py OUT``.

Sphinx reads a mirror of the repository's texts: every page, the examples as pages of their cells, and the Python
interface from its docstrings. A link to a file that is no page leads to the repository. Any warning, a dead link or a
page that no section holds among them, ends it with status 1.
"""

from __future__ import annotations

import argparse
import os
import re
import shutil
import sys
import tempfile
from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from docutils.nodes import math, math_block
    from sphinx.application import Sphinx
    from sphinx.writers.html5 import HTML5Translator

ROOT = Path(__file__).resolve().parents[1]
REPOSITORY = "https://github.com/er-damper/er-damper/blob/main/"
ASIDE = {".venv", "build", "install", "log", "test", "src", "site"}
"""Folders whose texts are no pages: those of packages are shown where they are installed from."""
PICTURES = (".svg", ".png", ".gif", ".webp", ".jpg")
SECTIONS = {
    "Start": ["docs/tutorial", "docs/my_rig"],
    "The lab": [
        "docs/lab", "docs/open", "docs/data", "docs/identification", "docs/plan", "docs/report", "docs/model_file",
        "docs/export", "docs/fleet", "docs/notation",
    ],
    "Python": ["docs/library", "docs/interface", "examples/index"],
    "Observers and control": ["docs/observers", "docs/fault_estimator", "docs/control"],
    "ROS 2": [
        "docs/nodes", "docs/vehicle", "docs/car", "docs/hardware", "docs/monitor", "docs/reliability", "docs/security",
    ],
    "Effects": ["docs/effects/README"],
    "Results": ["docs/results/*"],
    "Project": [
        "ARCHITECTURE", "CONTRIBUTING", "CHANGELOG", "SECURITY", "docs/dependencies", "docs/migration",
        "docs/decisions/*",
    ],
}  # fmt: skip
"""The contents. A page that is not there yet is left out; one that stands nowhere is a warning."""
CONF = {
    "project": "Semi-active dampers on ROS 2",
    "author": "ER damper developers",
    "extensions": ["myst_parser", "sphinx.ext.autodoc", "sphinx.ext.napoleon", "docs_site"],
    "html_math_renderer": "mathml",
    "html_theme": "furo",
    "html_show_copyright": False,
    "html_title": "Semi-active dampers on ROS 2",
    "myst_heading_anchors": 6,
    "myst_enable_extensions": ["dollarmath"],
    "autodoc_typehints": "signature",
    "autodoc_member_order": "bysource",
    "python_use_unqualified_type_names": True,
    "suppress_warnings": ["myst.header", "misc.highlighting_failure"],
}
LINK = re.compile(r"(?<=\]\()([^)#\s]+)(?=[)#])")
CELL = re.compile(r"^# %%(.*)\n", re.M)


def setup(app: Sphinx) -> None:
    """Sphinx's hook of an extension: equations as MathML, since its own ways need a network or LaTeX."""
    from docutils.nodes import SkipNode
    from latex2mathml.converter import convert

    def inline(translator: HTML5Translator, node: math) -> None:
        translator.body.append(convert(node.astext()))
        raise SkipNode

    def block(translator: HTML5Translator, node: math_block) -> None:
        translator.body.append(f"<p>{convert(node.astext(), display='block')}</p>")
        raise SkipNode

    app.add_html_math_renderer("mathml", (inline, None), (block, None))


def relinked(text: str, place: Path, pages: set[str]) -> str:
    """A page's text with links to what is no page leading to the repository; `place` is its path in the repository."""

    def link(match: re.Match[str]) -> str:
        target = match[1]
        if "://" in target:
            return target
        path = os.path.normpath(place.parent / target)
        if path == "examples":
            return os.path.relpath("examples/index.md", place.parent)
        known = path in pages or path.endswith(PICTURES) or not (ROOT / path).exists()
        return target if known else REPOSITORY + path

    return LINK.sub(link, text)


def notebook(text: str) -> str:
    """A script of cells as a page: texts as they are, code in fences."""
    parts = CELL.split(text)
    page = []
    for kind, cell in zip(parts[1::2], parts[2::2]):
        if "markdown" in kind:
            page.append(re.sub(r"^# ?", "", cell.strip(), flags=re.M))
        elif cell.strip():
            page.append(f"```python\n{cell.strip()}\n```")
    return "\n\n".join(page) + "\n"


def interface() -> str:
    """The page of the Python interface: what `import er_model_lab` offers, from the docstrings."""
    import inspect

    import er_model_lab as lab

    entries = []
    for name in sorted(lab.__all__):
        what = getattr(lab, name)
        kind = "class" if inspect.isclass(what) else "function" if callable(what) else ""
        if kind:
            rest = "\n   :members:\n   :exclude-members: __init__\n" if kind == "class" else "\n"
            entries.append(f".. auto{kind}:: er_model_lab.{name}{rest}")
    rst = "\n".join(entries)
    return f"# Python interface\n\n`import er_model_lab as lab`\n\n```{{eval-rst}}\n{rst}\n```\n"


def contents(pages: set[str]) -> str:
    """The contents, below what README.md says."""
    lists = []
    for title, entries in SECTIONS.items():
        there = [e for e in entries if "*" in e or f"{e}.md" in pages]
        body = "\n".join(there)
        glob = ":glob:\n" if any("*" in e for e in there) else ""
        lists.append(
            f"```{{toctree}}\n:hidden:\n:caption: {title}\n:maxdepth: 1\n{glob}\n{body}\n```\n"
        )
    return "\n".join(lists)


def mirror(source: Path) -> None:
    """Write the tree that Sphinx reads."""
    texts = {
        str(path.relative_to(ROOT)): path
        for path in ROOT.rglob("*")
        if path.suffix in (".md", *PICTURES)
        and not ASIDE & set(path.relative_to(ROOT).parts[:-1])
        and not any(part.startswith(".") for part in path.relative_to(ROOT).parts)
    }
    written = {
        name: path.read_text("utf-8") for name, path in texts.items() if path.suffix == ".md"
    }
    scripts = sorted((ROOT / "examples").glob("*.py"))
    written |= {f"examples/{path.stem}.md": notebook(path.read_text("utf-8")) for path in scripts}
    names = "\n".join(path.stem for path in scripts)
    written["examples/index.md"] = f"# Examples\n\n```{{toctree}}\n:maxdepth: 1\n\n{names}\n```\n"
    written.pop("examples/README.md", None)
    written["docs/effects/README.md"] += "\n```{toctree}\n:hidden:\n:glob:\n\n*\n```\n"
    written["docs/interface.md"] = interface()
    written["index.md"] = written.pop("README.md") + "\n" + contents(set(written))
    for name, text in written.items():
        (source / name).parent.mkdir(parents=True, exist_ok=True)
        (source / name).write_text(relinked(text, Path(name), set(written)), encoding="utf-8")
    for name, path in texts.items():
        if path.suffix != ".md":
            (source / name).parent.mkdir(parents=True, exist_ok=True)
            shutil.copy(path, source / name)


def main(argv: list[str]) -> int:
    """Build the site; returns the exit status."""
    parser = argparse.ArgumentParser(prog="docs_site.py", description=__doc__)
    parser.add_argument("out", type=Path, help="folder for the site")
    chosen = parser.parse_args(argv)
    from sphinx.application import Sphinx as Build

    with tempfile.TemporaryDirectory() as folder:
        source = Path(folder) / "source"
        mirror(source)
        built = Build(
            source, None, chosen.out, Path(folder) / "read", "html", CONF, warningiserror=True
        )  # fmt: skip
        built.build()
    return int(built.statuscode)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
