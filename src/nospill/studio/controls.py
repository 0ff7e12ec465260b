"""The controls of one tab, laid out in one panel: what is answered above, the tray and the rest in tabs below.

One panel and not two, so that a window of any width has the same controls and leaves space for the scene.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from nospill.studio.documents import export_choices
from nospill.studio.forms import Edited, FieldGroup
from nospill.studio.page_script import page_setup
from nospill.studio.tray_plan import WIDTH

if TYPE_CHECKING:
    import viser

NEW_OBSTACLES = {"Box": "box", "Cylinder": "cylinder"}
"""Shapes that are added, by their buttons; another shape is chosen afterwards."""
NO_OBSTACLE = "none"
"""What stands in the place of an obstacle while there are none."""
_LAST = 1e6
"""Order of what stands below fields that are added later."""
_FIRST, _STOP, _SECOND = (0, 114, 178), (166, 60, 0), (110, 118, 126)
"""Colours of buttons: the one that most come for, the one that ends something, all others."""


class Controls:
    """Handles of everything a session sets or listens to.

    Attributes:
        groups: fields by their heading; "Object", "Obstacle" and "File" besides those of `fields.scenario_fields`.
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
        self._gui, self._title = gui, ""
        gui.main_panel.dock_right()
        gui.main_panel.set_width(WIDTH + 30)
        gui.add_html(page_setup())
        self._add_planning(gui)
        tabs = gui.add_tab_group()
        with tabs.add_tab("Tray"):
            self._add_tray(gui, typed)
        with tabs.add_tab("Around"):
            self._add_surroundings(gui, typed)
        with tabs.add_tab("Scenario"):
            for title in ("Robot", "Path", "Motion", "Tray", "Planning"):
                self._add_group(gui, title, typed, expanded=title in ("Robot", "Path", "Motion"))
            hint = "re-plan from the last answer: faster; or search anew"
            self.warm = gui.add_checkbox("Start from last", True, hint=hint)
        with tabs.add_tab("Certificate"):
            self.warnings = gui.add_html("")
            self.certificate = gui.add_html(
                "<div style='padding:2px 10px;font-size:13px'>Nothing is planned yet.</div>"
            )
        self.motion_tab = tabs.add_tab("Motion")
        with self.motion_tab:
            self.shown = gui.add_button_group("Show", ("Layout", "Motion"))
        with tabs.add_tab("Files"):
            self._add_files(gui, folder, typed, opens)

    def _add_planning(self, gui: viser.GuiApi) -> None:
        self.plan_button = gui.add_button("Plan", color=_FIRST)
        self.stop_button = gui.add_button("Stop", visible=False, color=_STOP)
        self.headline = gui.add_html("<div id='nospill-headline'></div>")
        self.details = gui.add_html("")
        self.history = gui.add_button_group("History", ("Undo", "Redo"), hint="Ctrl+Z, Ctrl+Shift+Z")

    def _add_tray(self, gui: viser.GuiApi, typed: Edited) -> None:
        self.plan_picture = gui.add_html("")
        self.drag = gui.add_text("Drag", "")  # hidden by the picture, which it must follow
        self.snap = gui.add_checkbox("Snap to 5 mm", True)
        self.objects = gui.add_button_group("Add", ("Cup", "Solid", "Copy"), hint="Copy: of the object below")
        self.selection: Any = gui.add_dropdown("Object", ("1",))
        self._add_group(gui, "Object", typed, expanded=True)
        self.remove_button = gui.add_button("Remove this object", color=_SECOND)

    def _add_surroundings(self, gui: viser.GuiApi, typed: Edited) -> None:
        self.new_obstacle = gui.add_button_group("Add", tuple(NEW_OBSTACLES), hint="an obstacle below the path")
        self.obstacle: Any = gui.add_dropdown("Obstacle", (NO_OBSTACLE,), hint="its arrows in the layout move it")
        self._add_group(gui, "Obstacle", typed, expanded=True)
        self.remove_obstacle = gui.add_button("Remove this obstacle", color=_SECOND)

    def _add_files(self, gui: viser.GuiApi, folder: Path, typed: Edited, opens: Sequence[str]) -> None:
        self.file_message = gui.add_html("")
        save = gui.add_folder("Save the scenario")
        self.groups["File"] = FieldGroup(gui, save, edited=typed)
        with save:
            self.save_button = gui.add_button("Save", hint=f"as NAME.toml in {folder}", order=_LAST, color=_FIRST)
            self.download_button = gui.add_button("Download", order=_LAST, color=_SECOND)
        with gui.add_folder("Open a scenario"):
            self.choice = gui.add_dropdown("Scenario", opens)
            self.open_button = gui.add_button("Open", color=_SECOND)
            self.upload = gui.add_upload_button("Upload a file", mime_type=".toml", color=_SECOND)
        with gui.add_folder("Export the plan"):
            self.format = gui.add_dropdown("Format", export_choices())
            self.export_button = gui.add_button("Export", color=_SECOND)

    def _add_group(self, gui: viser.GuiApi, title: str, typed: Edited, *, expanded: bool) -> None:
        folder = gui.add_folder(title, expand_by_default=expanded)
        self.groups[title] = FieldGroup(gui, folder, edited=typed)

    def show_title(self, name: str) -> None:
        """Name the scenario at the head of the panel."""
        title = f"{name} · nospill studio"
        if title != self._title:
            self._title = title
            self._gui.set_panel_label(title)

    def set_content(self, handle: viser.GuiHtmlHandle, content: str) -> None:
        """Write HTML anew where it differs."""
        if handle.content != content:
            handle.content = content

    def show_busy(self, busy: bool) -> None:
        """Offer Stop while planning, Plan otherwise."""
        if self.stop_button.visible != busy:
            self.stop_button.visible = busy
            self.plan_button.visible = not busy

    def show_possible(self, *, plan: bool, save: bool, export: bool, remove: bool, remove_obstacle: bool) -> None:
        """Let the buttons be pressed that can do something."""
        for handle, possible in (
            (self.plan_button, plan),
            (self.export_button, export),
            (self.save_button, save),
            (self.remove_button, remove),
            (self.remove_obstacle, remove_obstacle),
        ):
            if handle.disabled == possible:
                handle.disabled = not possible

    def show_objects(self, choices: Sequence[str], selected: int) -> None:
        """The objects by number and name."""
        _offer(self.selection, choices)
        if self.selection.value != choices[selected]:
            self.selection.value = choices[selected]

    def show_obstacles(self, choices: Sequence[str], chosen: int) -> None:
        """The obstacles by number and name, or that there are none."""
        choices = choices or (NO_OBSTACLE,)
        _offer(self.obstacle, choices)
        if self.obstacle.value != choices[chosen]:
            self.obstacle.value = choices[chosen]

    def show_choices(self, choices: Sequence[str]) -> None:
        """What can be opened."""
        _offer(self.choice, choices)


def _offer(dropdown: Any, choices: Sequence[str]) -> None:
    if tuple(dropdown.options) != tuple(choices):
        dropdown.options = tuple(choices)
