"""Fields on the screen: text and choices in a folder, each with its fault below it."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

from nospill.studio.draft import Draft, Key
from nospill.studio.fields import NO_LIQUID, OWN_LIQUID, Field, read_text, shown_text
from nospill.studio.page_script import field_note

if TYPE_CHECKING:
    import viser

Edited = Callable[[Field, Callable[[], str]], None]
"""Called with a field and what reads its text: viser calls from several threads, so it is read under the lock."""


@dataclass(slots=True)
class _Shown:
    field: Field
    entry: Any  # a text or a dropdown of viser, whose handles share no typed base with a value
    note: viser.GuiHtmlHandle
    known: str  # what was last read from the entry or written to it: any other value in it is yet to be read

    def read(self) -> str:
        self.known = str(self.entry.value)
        return self.known


class FieldGroup:
    """The fields of one folder. They are made anew only when there are others, so that typing is not disturbed."""

    def __init__(self, gui: viser.GuiApi, folder: Any, *, edited: Edited) -> None:
        """Nothing is shown yet.

        Args:
            gui: of one client.
            folder: container of viser.
            edited: called from viser's threads.
        """
        self._gui, self._folder, self._edited = gui, folder, edited
        self._shown: list[_Shown] = []

    def show(self, fields: Sequence[Field], draft: Draft, notes: Mapping[Key, Sequence[str]]) -> None:
        """Show values and faults; a text that reads as the value stays as it was typed."""
        if [item.field for item in self._shown] != list(fields):
            self.clear()
            with self._folder:
                self._shown = [self._make(field, draft.value(field.key)) for field in fields]
        for item in self._shown:
            self._update(item, draft.value(item.field.key))
            note = field_note(notes.get(item.field.key, ()), item.field.default)
            if item.note.content != note:
                item.note.content = note

    def clear(self) -> None:
        """Take the fields away."""
        for item in self._shown:
            item.entry.remove()
            item.note.remove()
        self._shown = []

    def _make(self, field: Field, value: Any) -> _Shown:
        hint = field.hint or None
        entry: Any
        if field.kind == "choice":
            entry = self._gui.add_dropdown(
                field.label, field.choices, initial_value=_chosen(field, value, field.choices), hint=hint
            )
        else:
            text = shown_text(value, field.kind)
            entry = self._gui.add_text(field.label, text, multiline=field.kind == "points", hint=hint)

        shown = _Shown(field, entry, self._gui.add_html(field_note((), field.default)), str(entry.value))

        @entry.on_update
        def _(event: Any) -> None:
            if event.client is not None:  # what this side sets carries none
                self._edited(field, shown.read)

        return shown

    def _update(self, item: _Shown, value: Any) -> None:
        field, entry = item.field, item.entry
        if entry.value != item.known:
            return  # typed on since the draft was written, and about to be read: writing now would lose keys
        if field.kind == "choice":
            wanted = _chosen(field, value, entry.options)
        else:
            same = repr(read_text(entry.value, field.kind)) == repr(value)
            wanted = entry.value if same else shown_text(value, field.kind)
        if entry.value != wanted:
            item.known = wanted
            entry.value = wanted


def _chosen(field: Field, value: Any, choices: Sequence[str]) -> str:
    """The choice a value stands for: the first one is what holds while there is none."""
    if field.key[-1] == "liquid" and field.key[0] == "cargo" and not isinstance(value, str):
        return NO_LIQUID if value is None else OWN_LIQUID
    return value if isinstance(value, str) and value in choices else choices[0]
