"""The documents become a web site without a warning, and nothing of it comes from another host."""

import re
import subprocess
import sys

import pytest

from test.conftest import ROOT

pytestmark = pytest.mark.slow
LOADED = re.compile(
    r'<(?:script|img|iframe)[^>]*src="(?:https?:)?//|<link[^>]*rel="(?:stylesheet|icon|preload)"[^>]*href="(?:https?:)?//'
)


def made(out):
    """The site, built without a warning."""
    built = subprocess.run(
        [sys.executable, ROOT / "tools/docs_site.py", out], cwd=ROOT, capture_output=True, text=True, check=False
    )  # fmt: skip
    assert built.returncode == 0, built.stderr[-4000:]
    return out


@pytest.fixture(scope="module")
def site(tmp_path_factory):
    return made(tmp_path_factory.mktemp("site"))


def test_every_page_is_there_and_needs_no_network(site):
    kept = [path for path in (ROOT / "docs").rglob("*.md")]
    for path in kept:
        page = site / path.relative_to(ROOT).with_suffix(".html")
        assert page.is_file(), path
    loaded = [str(page) for page in site.rglob("*.html") if LOADED.search(page.read_text("utf-8"))]
    assert loaded == []


def test_the_interface_is_there_with_its_docstrings(site):
    import er_model_lab as lab

    page = (site / "docs/interface.html").read_text("utf-8")
    assert all(f'id="er_model_lab.{name}"' in page for name in ("diagnose", "improve", "load"))
    assert (lab.diagnose.__doc__ or "").split("\n", maxsplit=1)[0].split("`")[0] in page


def test_equations_are_typeset_and_words_are_found(site):
    card = (site / "docs/effects/coulomb_friction.html").read_text("utf-8")
    assert "<math" in card
    assert "$$" not in card
    assert "friction" in (site / "searchindex.js").read_text("utf-8")
