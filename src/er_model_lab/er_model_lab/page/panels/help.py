"""Help on words: under the mouse, by Tab, and all of them in a dialogue."""

from __future__ import annotations

from typing import TypeVar

from nicegui import ui
from nicegui.element import Element

from er_model_lab.output.text.glossary import TERMS

STYLE = """
.term { position: relative; cursor: help; text-decoration: underline dotted; text-underline-offset: 3px; }
.term:is(:hover, :focus)::after {
  content: attr(data-help); position: absolute; left: 0; top: calc(100% + 4px); z-index: 9000; width: max-content;
  max-width: min(270px, 80vw); padding: 6px 9px; border-radius: 4px; background: #1f2933; color: #fff;
  font: 400 13px/1.35 sans-serif; white-space: normal; text-align: left; box-shadow: 0 2px 8px #0006;
}
"""
E = TypeVar("E", bound=Element)


def helped(element: E, *words: str) -> E:
    """An element whose words are explained where the mouse or the keyboard is on it."""
    element.classes("term")
    element.props["tabindex"] = "0"
    element.props["data-help"] = " ".join(
        f"{word.capitalize()}: {TERMS[word]}" if len(words) > 1 else TERMS[word] for word in words
    )
    element.props["aria-describedby"] = " ".join(map(place, words))
    return element


def heading(text: str, *words: str) -> ui.label:
    """A heading, explained where words are given."""
    made = ui.label(text).classes("font-bold w-fit").props("role=heading aria-level=2")
    return helped(made, *words) if words else made


def described() -> None:
    """What screen readers say of explained words, which nobody sees."""
    with ui.element("div").props("hidden"):
        for word, sentence in TERMS.items():
            ui.label(sentence).props(f"id={place(word)}")


def show_all() -> None:
    """A dialogue with every word."""
    with ui.dialog() as dialog, ui.card().classes("max-w-xl"):
        heading("Words of the lab")
        for word, sentence in TERMS.items():
            ui.label(f"{word.capitalize()}. {sentence}").classes("text-sm")
        ui.button("Close", on_click=dialog.close).props("flat no-caps")
    dialog.on("hide", dialog.delete)
    dialog.open()


def place(word: str) -> str:
    """Where a word is explained on the page."""
    return f"word-{word.replace(' ', '-')}"
