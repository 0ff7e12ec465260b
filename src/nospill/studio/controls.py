"""The controls of one tab, laid out: the tray on the left, scenario and answer on the right."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from nospill.studio.documents import export_choices
from nospill.studio.forms import Edited, FieldGroup
from nospill.studio.tray_plan import WIDTH

if TYPE_CHECKING:
    import viser

_RIGHT = 400
"""px; width of the right panel."""
_LAST = 1e6
"""Order of what stands below fields that are added later."""


class Controls:
    """Handles of everything a session sets or listens to.

    Attributes:
        groups: fields by their heading; "Object" and "File" besides those of `fields.scenario_fields`.
        motion_tab: container for the player.
    """

    def __init__(self, gui: viser.GuiApi, folder: Path, *, typed: Edited, opens: Sequence[str]) -> None:
        """Add everything.

        Args:
            gui: of one client.
            folder: of the scenario files, for its name.
            typed: called when something is typed or chosen in a field.
            opens: what can be opened.
        """
        self.groups: dict[str, FieldGroup] = {}
        gui.set_panel_label("nospill studio")
        gui.main_panel.dock_right()
        gui.main_panel.set_width(_RIGHT)
        self._add_planning(gui)
        tabs = gui.add_tab_group()
        with tabs.add_tab("Scenario"):
            self.reach = gui.add_html("")
            for title in ("Robot", "Path", "Motion", "Tray", "Planning"):
                self._add_group(gui, title, typed, expanded=title in ("Robot", "Path", "Motion"))
        with tabs.add_tab("Certificate"):
            self.certificate = gui.add_html(
                "<div style='padding:2px 10px;font-size:13px'>Nothing is planned yet.</div>"
            )
        self.motion_tab = tabs.add_tab("Motion")
        with self.motion_tab:
            self.shown = gui.add_button_group("Show", ("Layout", "Motion"))
        with tabs.add_tab("Files"):
            self._add_files(gui, folder, typed, opens)
        panel = gui.add_panel()
        with panel.add_tab("Tray"):
            self._add_tray(gui, typed)
        panel.dock_left()
        panel.set_width(WIDTH + 20)

    def _add_planning(self, gui: viser.GuiApi) -> None:
        self.plan_button = gui.add_button("Plan", color=(0, 114, 178))
        self.stop_button = gui.add_button("Stop", visible=False, color=(166, 60, 0))
        self.warm = gui.add_checkbox(
            "Start from last", True, hint="re-plan from the last answer: faster; or search anew"
        )
        self.history = gui.add_button_group("History", ("Undo", "Redo"))
        self.progress = gui.add_html("")
        self.faults = gui.add_html("")
        self.verdict = gui.add_html("")

    def _add_tray(self, gui: viser.GuiApi, typed: Edited) -> None:
        self.plan_picture = gui.add_html("")
        self.drag = gui.add_text("Drag", "")  # hidden by the picture, which it must follow
        self.snap = gui.add_checkbox("Snap to 5 mm", True)
        self.objects = gui.add_button_group("Objects", ("Cup", "Solid", "Copy", "Remove"), hint="add, copy, take away")
        self.selection: Any = gui.add_dropdown("Object", ("1",))
        self._add_group(gui, "Object", typed, expanded=True)

    def _add_files(self, gui: viser.GuiApi, folder: Path, typed: Edited, opens: Sequence[str]) -> None:
        self.file_message = gui.add_html("")
        with gui.add_folder("Open a scenario"):
            self.choice = gui.add_dropdown("Scenario", opens)
            self.open_button = gui.add_button("Open")
            self.upload = gui.add_upload_button("Upload a file", mime_type=".toml")
        save = gui.add_folder("Save the scenario")
        self.groups["File"] = FieldGroup(gui, save, edited=typed)
        with save:
            self.save_button = gui.add_button("Save", hint=f"as NAME.toml in {folder}", order=_LAST)
            self.download_button = gui.add_button("Download", order=_LAST)
        with gui.add_folder("Export the plan"):
            self.format = gui.add_dropdown("Format", export_choices())
            self.export_button = gui.add_button("Export")

    def _add_group(self, gui: viser.GuiApi, title: str, typed: Edited, *, expanded: bool) -> None:
        folder = gui.add_folder(title, expand_by_default=expanded)
        self.groups[title] = FieldGroup(gui, folder, edited=typed)

    def set_content(self, handle: viser.GuiHtmlHandle, content: str) -> None:
        """Write HTML anew where it differs."""
        if handle.content != content:
            handle.content = content

    def show_busy(self, busy: bool) -> None:
        """Offer Stop while planning, Plan otherwise."""
        if self.stop_button.visible != busy:
            self.stop_button.visible = busy
            self.plan_button.visible = not busy

    def show_possible(self, *, plan: bool, export: bool) -> None:
        """Let the buttons be pressed that can do something."""
        for handle, possible in ((self.plan_button, plan), (self.export_button, export), (self.save_button, plan)):
            if handle.disabled == possible:
                handle.disabled = not possible

    def show_objects(self, choices: Sequence[str], selected: int) -> None:
        """The objects by number and name."""
        _offer(self.selection, choices)
        if self.selection.value != choices[selected]:
            self.selection.value = choices[selected]

    def show_choices(self, choices: Sequence[str]) -> None:
        """What can be opened."""
        _offer(self.choice, choices)


def _offer(dropdown: Any, choices: Sequence[str]) -> None:
    if tuple(dropdown.options) != tuple(choices):
        dropdown.options = tuple(choices)
