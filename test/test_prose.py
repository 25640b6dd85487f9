"""How pages for people are written: short sentences, lines that fit a screen, the field's words."""

from __future__ import annotations

import re
from collections.abc import Iterator

import pytest

from test.conftest import ROOT

PAGES = [
    *(ROOT / name for name in ("README.md", "ARCHITECTURE.md", "CONTRIBUTING.md", "SECURITY.md")),
    *sorted((ROOT / "docs").glob("*.md")),
]
RESULTS = sorted((ROOT / "docs/results").glob("*.md"))
LONGEST_LINE, LONGEST_SENTENCE, MEAN = 120, 37, 18
"""Characters of a line (tables, code and links excepted), words of a sentence, and of a page's mean sentence."""
AVOID = {
    r"\bof which nothing is known\b": "unknown",
    r"\bhow (?:they|it) do(?:es)? beside\b": "how they compare with",
    r"\bmakes? up for nothing\b": "changes nothing",
    r"\bis no noise\b": "is not noise",
    r"\bthat is noise there\b": "has reached its noise",
    r"\bwhat of (?:it|them|the)\b": "which part of",
    r"\bkeeps? to no equation\b": "follows no equation",
    r"\btells? nothing of\b": "says nothing about",
    r"\bwhatever there is\b": "name it",
    r"\bbeholds?\b": "sees",
    r"\butili[sz]e": "use",
    r"\bin order to\b": "to",
    r"\bleverag": "use",
    r"\bseamless": "say what happens",
    r"\bsimply\b|\bjust works\b": "leave it out",
}
"""Words that readers stumbled over, and what says it better."""


def prose(text: str) -> Iterator[str]:
    """Paragraphs and items without code, tables, headings, pictures and the targets of links."""
    plain = re.sub(r"^```.*?^```", "", text, flags=re.M | re.S)
    plain = re.sub(r"^\$\$.*?\$\$", "", plain, flags=re.M | re.S)
    lines = [
        re.sub(r"^\s*([-*]|\d+\.) ", "\n", line)
        for line in plain.splitlines()
        if not line.lstrip().startswith(("|", "#", "!", "<"))
    ]
    for part in re.split(r"\n\s*\n|\n(?=\n)", "\n".join(lines)):
        if part.strip():
            yield re.sub(r"\[([^\]]*)\]\([^)]*\)", r"\1", " ".join(part.split()))


def sentences(text: str) -> list[str]:
    """Sentences of a page; a colon or semicolon ends one, too."""
    found = [s for part in prose(text) for s in re.split(r"(?<=[.!?:;])\s+", part)]
    return [s for s in found if len(s.split()) > 1]


@pytest.mark.parametrize("path", [*PAGES, *RESULTS], ids=lambda path: path.name)
def test_lines_fit_a_screen(path) -> None:
    code, long = False, []
    for number, line in enumerate(path.read_text(encoding="utf-8").splitlines(), 1):
        code ^= line.lstrip().startswith("```")
        whole = re.sub(r"`[^`]*`", lambda m: m[0].replace(" ", "_"), line)  # no command is broken
        apart = max(map(len, whole.split()), default=0) > LONGEST_LINE - 30
        held = line.lstrip().startswith(("|", "$$", "!["))
        if len(line) > LONGEST_LINE and not (code or apart or held):
            long.append(number)
    assert long == []


@pytest.mark.parametrize("path", PAGES, ids=lambda path: path.name)
def test_sentences_are_short(path) -> None:
    found = sentences(path.read_text(encoding="utf-8"))
    lengths = [len(s.split()) for s in found]
    assert [s for s, n in zip(found, lengths) if n > LONGEST_SENTENCE] == []
    assert sum(lengths) <= MEAN * len(lengths)


@pytest.mark.parametrize("path", PAGES, ids=lambda path: path.name)
def test_words_that_readers_stumble_over_are_gone(path) -> None:
    text = " ".join(prose(path.read_text(encoding="utf-8")))
    found = [
        f"{m[0]!r}: better {better!r}"
        for bad, better in AVOID.items()
        for m in re.finditer(bad, text, re.I)
    ]
    assert found == []


def test_the_readme_is_read_to_its_end() -> None:
    """90 lines, and no paragraph that promises more than follows."""
    text = (ROOT / "README.md").read_text(encoding="utf-8")
    assert len(text.splitlines()) <= 90
    for path in PAGES:
        parts = re.split(r"\n\s*\n", path.read_text(encoding="utf-8"))
        said = zip(parts, [*parts[1:], "# End"], strict=True)
        left = [a for a, b in said if a.endswith(":") and re.match(r"[A-Z#]", b)]
        assert left == [], path.name


def test_an_entry_of_the_changelog_is_one_line() -> None:
    lines = (ROOT / "CHANGELOG.md").read_text(encoding="utf-8").splitlines()
    assert [line for line in lines if len(line) > LONGEST_LINE] == []
    assert [line for line in lines if line.startswith(" ")] == []


def test_the_check_finds_what_it_looks_for() -> None:
    """It must be able to fail."""
    assert sentences("A b. C d e: f g.\n\n| not | this |\n") == ["A b.", "C d e:", "f g."]
    assert re.search(next(iter(AVOID)), "a damper of which nothing is known")
