"""Fields on the screen against a browser that types while the model is being written."""

from __future__ import annotations

import contextlib
from collections.abc import Callable
from types import SimpleNamespace
from typing import Any

from nospill.studio.draft import Draft
from nospill.studio.fields import Field
from nospill.studio.forms import FieldGroup

FILL = Field(("fill",), "Fill")


class Entry:
    """A text of viser: a value that both sides set."""

    def __init__(self, value: str) -> None:
        self.value = value
        self.updated: Callable[[Any], None]

    def on_update(self, function: Callable[[Any], None]) -> Callable[[Any], None]:
        self.updated = function
        return function

    def arrives(self, text: str) -> None:
        """What viser's loop does with a message, before a thread calls the function."""
        self.value = text

    def told(self) -> None:
        self.updated(SimpleNamespace(client=object()))


class Screen:
    """The part of viser's interface that a group of fields uses, and the model behind it."""

    def __init__(self) -> None:
        self.draft = Draft({"fill": "49 mm", "cargo": [{"name": "cup"}]})
        self.group = FieldGroup(self, contextlib.nullcontext(), edited=self._typed)  # pyright: ignore[reportArgumentType]
        self.show()

    def add_text(self, _label: str, value: str, **_options: Any) -> Entry:
        self.entry = Entry(value)
        return self.entry

    def add_html(self, _content: str, **_options: Any) -> Any:
        return SimpleNamespace(content="", visible=False)

    def _typed(self, field: Field, read: Callable[[], str]) -> None:
        text = read()
        self.draft.type_in(field.key, text)
        self.between()
        self.show()

    def between(self) -> None:
        """What comes in after the draft is written and before the fields are."""

    def show(self) -> None:
        self.group.show([FILL], self.draft, {})


def test_a_key_that_arrives_while_the_last_one_is_shown_is_not_taken_back() -> None:
    screen = Screen()
    screen.between = lambda: screen.entry.arrives("47")
    screen.entry.arrives("4")
    screen.entry.told()
    assert (screen.entry.value, screen.draft.value(("fill",))) == ("47", "4")
    del screen.between
    screen.entry.told()
    assert (screen.entry.value, screen.draft.value(("fill",))) == ("47", "47")


def test_what_the_model_changes_is_shown() -> None:
    screen = Screen()
    screen.entry.arrives("47 mm")
    screen.entry.told()
    screen.draft.undo()
    screen.show()
    assert screen.entry.value == "49 mm"
    screen.draft.redo()
    screen.show()
    assert screen.entry.value == "47 mm"
