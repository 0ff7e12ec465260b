"""One browser tab: its draft, its planner, and what it sees. Tabs share nothing but the number of seats."""

from __future__ import annotations

import threading
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from nospill.plans.plan import Plan
from nospill.studio import documents
from nospill.studio.changes import NEW_CUP, NEW_SOLID, choose
from nospill.studio.checks import Check, check
from nospill.studio.controls import Controls
from nospill.studio.draft import Draft, choices_of, label_of, millimetres
from nospill.studio.fields import Field, faults_by_field, object_fields, read_text, scenario_fields
from nospill.studio.filing import FileDesk
from nospill.studio.layout_view import ROOT, LayoutView
from nospill.studio.motion_view import MotionView
from nospill.studio.obstacle_desk import ObstacleDesk
from nospill.studio.obstacles import obstacle_fields
from nospill.studio.pages import (
    certificate_table,
    details,
    headline,
    warning_list,
)
from nospill.studio.placing import GRID, at_of_entry, free_place, place_objects, snapped, tray_size
from nospill.studio.planning import BUSY, PlanningDesk, PlanningSlots, PlanningState
from nospill.studio.tray_plan import draw_plan, read_drag

if TYPE_CHECKING:
    import viser

PROGRESS_EVERY = 0.05
"""s; how often the figures of a running plan are written anew."""

_LAST_MOMENT = 2.0
"""s; how long a closing session waits for its threads."""


class Session:
    """Connects the model to the controls of one client. Every callback of the browser ends in `_refresh`."""

    def __init__(
        self, client: viser.ClientHandle, table: Mapping[str, Any], *, folder: Path, seats: PlanningSlots
    ) -> None:
        """Build the controls and show the scenario.

        Args:
            client: the browser tab.
            table: of the scenario it starts with.
            folder: where scenario files are opened and saved.
            seats: shared by all sessions of the server.
        """
        self._client = client
        self.draft = Draft(table)
        self.checked: Check = check(self.draft.table)
        self.desk = PlanningDesk(seats, report=self._planning_changed)
        self._path = self.checked.scene.path if self.checked.scene else None
        self._planned: dict[str, Any] | None = None
        self._snapping = True
        self._reports = 0
        self._obstacle = ""
        self._before: float | None = None
        self._lock = threading.RLock()
        self._closed = threading.Event()
        self._progress_due = threading.Event()
        self.controls = Controls(client.gui, folder, typed=self._typed, opens=documents.scenario_choices(folder))
        self._layout = LayoutView(client, said=self._reach_changed)
        self._obstacles = ObstacleDesk(client.scene, f"{ROOT}/arrows", self.controls, self.draft, edit=self._edit)
        self._motion = MotionView(client, self.controls.motion_tab)
        self.files = FileDesk(
            client,
            self.controls,
            folder,
            take=self._open,
            checked=lambda: self.checked,
            plan=lambda: self._motion.plan,
        )
        self._connect()
        self._threads = (
            threading.Thread(target=self._layout.run, args=(self._closed,), daemon=True),
            threading.Thread(target=self._write_progress, daemon=True),
        )
        for thread in self._threads:
            thread.start()
        self._refresh()

    @property
    def camera(self) -> viser.CameraHandle:
        """What the tab's scene is seen through."""
        return self._client.camera

    def close(self) -> None:
        """Stop what runs; the browser is gone."""
        self._closed.set()
        self._progress_due.set()
        self.desk.stop()
        self._layout.wake()
        self._motion.close()
        for thread in self._threads:
            thread.join(_LAST_MOMENT)

    def _connect(self) -> None:
        """Let the controls do what they say."""
        controls = self.controls
        actions: tuple[tuple[Any, Callable[[], None]], ...] = (
            (controls.plan_button, self._plan),
            (controls.stop_button, self.desk.stop),
            (controls.remove_button, self._remove),
        )
        for handle, action in actions:
            handle.on_click(lambda _event, action=action: action())
        groups: tuple[tuple[Any, dict[str, Callable[[], object]]], ...] = (
            (controls.history, {"Undo": self.draft.undo, "Redo": self.draft.redo}),
            (
                controls.objects,
                {
                    "Cup": lambda: self._add_object(NEW_CUP),
                    "Solid": lambda: self._add_object(NEW_SOLID),
                    "Copy": lambda: self._add_object(self.draft.cargo[self.draft.selected]),
                },
            ),
            (controls.shown, {"Layout": self._show_layout, "Motion": self._show_motion}),
        )
        for handle, choices in groups:
            handle.on_click(self._chosen_of(choices))
        controls.drag.on_update(self._from_browser(self._dragged))
        controls.snap.on_update(self._from_browser(self._snap))
        controls.selection.on_update(self._from_browser(self._select))
        self._client.camera.on_update(lambda _camera: self._layout.window_changed())

    def _chosen_of(self, choices: Mapping[str, Callable[[], object]]) -> Callable[[Any], None]:
        def run(event: Any) -> None:
            with self._lock:
                choices[event.target.value]()
                self._refresh(edited=event.target is not self.controls.shown)

        return run

    def _from_browser(self, action: Callable[[Any], None]) -> Callable[[Any], None]:
        def run(event: Any) -> None:
            if event.client is not None:  # what this side sets carries none
                with self._lock:
                    action(event.target.value)

        return run

    def _typed(self, field: Field, read: Callable[[], str]) -> None:
        with self._lock:
            text = read()
            if field.kind == "choice":
                self.draft.change(choose(self.draft, field, text, path=self._path))
            else:
                self.draft.type_in(field.key, read_text(text, field.kind))
            self._refresh()

    def _dragged(self, text: str) -> None:
        report = read_drag(text, objects=len(self.draft.cargo))
        if report is None:
            return
        self.draft.selected, self._reports = report.index, report.count
        if report.at is not None:
            x, y = snapped(*report.at, grid=GRID if self._snapping else None)
            self.draft.move(report.index, *at_of_entry(self.draft.table, report.index, (x, y)), ended=report.ended)
        self._refresh()

    def _snap(self, wanted: bool) -> None:
        self._snapping = wanted
        self._refresh(edited=False)

    def _select(self, choice: str) -> None:
        choices = choices_of(self.draft.cargo)
        if choice in choices:
            self.draft.selected = choices.index(choice)
            self._refresh(edited=False)

    def _add_object(self, entry: Mapping[str, Any]) -> None:
        """Add an object where there is space for it, on the tray itself."""
        entry = {key: value for key, value in entry.items() if key not in ("carrier", "seat_height")}
        x, y = free_place(self.draft.table, entry)
        self.draft.add({**entry, "at": [millimetres(x), millimetres(y)]})

    def _remove(self) -> None:
        with self._lock:
            self.draft.remove(self.draft.selected)
            self._refresh()

    def _edit(self, action: Callable[[], object], edited: bool) -> None:
        """Do something to the draft, or only to what is shown of it."""
        with self._lock:
            action()
            self._refresh(edited=edited)

    def _open(self, table: dict[str, Any]) -> None:
        with self._lock:
            self.draft.open(table)
            self._layout.look_again()
            self._refresh()

    def _plan(self) -> None:
        with self._lock:
            scene = self.checked.scene
            if scene is None or self._obstacle or not self.desk.start(scene, warm=self.controls.warm.value):
                return
            self._planned = self.draft.table

    def _planning_changed(self) -> None:
        """From the planner's thread: what is quick at once, figures by and by."""
        self._progress_due.set()

    def _write_progress(self) -> None:
        """Bring the state of planning to the browser; a state that lasted shorter than a moment may be left out."""
        while not self._closed.is_set():
            self._progress_due.wait()
            self._progress_due.clear()
            if self._closed.is_set():
                return
            state = self.desk.state
            try:
                self._show_state(state)
            except Exception as error:  # a tab that hangs in "planning" would be worse; a closed one takes nothing
                if not self._closed.is_set():
                    self.files.say(f"Internal error: {type(error).__name__}: {error}", wrong=True)
            self._closed.wait(PROGRESS_EVERY if state.stage in BUSY else 0.0)

    def _show_state(self, state: PlanningState) -> None:
        if state.stage in BUSY:
            self.controls.show_busy(True)
            with self._lock:
                self._show_answer(state)
        else:
            with self._lock:
                if state.plan is not None:
                    self._show_plan(state.plan)
                self._refresh(edited=False)
        self._client.flush()

    def _show_plan(self, plan: Plan) -> None:
        last = self._motion.plan
        if plan is not last:
            self._before = last.duration if last is not None else None
            self._motion.take(plan)
            self._layout.visible = False

    def _show_motion(self) -> None:
        if self._motion.plan is not None:
            self._motion.show()
            self._layout.visible = False

    def _show_layout(self) -> None:
        self._motion.hide()
        self._layout.visible = True

    def _forget_attempt(self) -> None:
        """What is on the screen is no longer what was planned, nor what failed."""
        if self._motion.shown:
            self._show_layout()

    def _reach_changed(self, text: str) -> None:
        """From the thread that draws the layout."""
        with self._lock:
            self._obstacle = text
            self._refresh(edited=False)

    def _refresh(self, *, edited: bool = True) -> None:
        """Check the draft and show everything anew that depends on it."""
        controls, draft = self.controls, self.draft
        with self._lock, self._client.atomic():
            if edited:
                self.checked = check(draft.table)
                if self.checked.scene is not None:
                    self._path = self.checked.scene.path
                    self._layout.show(self.checked.scene)
                if draft.table != self._planned:
                    self._forget_attempt()
            groups = scenario_fields(draft) | {
                "Object": object_fields(draft, draft.selected),
                "Obstacle": obstacle_fields(draft, draft.chosen),
                "File": [documents.NAME],
            }
            notes, _ = faults_by_field([field for fields in groups.values() for field in fields], self.checked.faults)
            for title, fields in groups.items():
                controls.groups[title].show(fields, draft, notes)
            controls.show_objects(choices_of(draft.cargo), draft.selected)
            self._obstacles.show(snapping=self._snapping, path=self._path)
            controls.set_content(controls.plan_picture, self._picture())
            name = draft.value(("name",))
            controls.show_title(name if isinstance(name, str) else "unnamed")
            right = self.checked.scene is not None
            controls.show_possible(
                plan=right and not self._obstacle,
                save=right,
                export=self._motion.plan is not None,
                remove=len(draft.cargo) > 1,
                remove_obstacle=bool(draft.obstacles),
            )
            controls.show_busy(self.desk.busy)
            self._show_answer(self.desk.state)

    def _picture(self) -> str:
        placed = place_objects(self.draft.table)
        there = {item.index for item in placed}
        return draw_plan(
            placed,
            tray_size(self.draft.table),
            selected=self.draft.selected,
            snapping=self._snapping,
            count=self._reports,
            missing=[label_of(entry, index) for index, entry in enumerate(self.draft.cargo) if index not in there],
        )

    def _show_answer(self, state: PlanningState) -> None:
        """Say what holds for the scenario on the screen; an answer to another one is the previous one."""
        controls, plan, scene = self.controls, self._motion.plan, self.checked.scene
        if state.stage not in BUSY and self.draft.table != self._planned:
            state = PlanningState()
        same = plan is not None and scene == plan.scene
        previous = not same or bool(self._obstacle) or state.stage == "failed"
        page = headline(
            state,
            plan,
            previous=previous,
            before=self._before,
            faults=len(self.checked.faults),
            reach=not self._obstacle,
        )
        controls.set_content(controls.headline, page)
        about = self.draft.value(("description",))
        page = details(
            state,
            plan,
            previous=previous,
            faults=self.checked.faults,
            obstacle=self._obstacle,
            about=about if isinstance(about, str) else "",
        )
        controls.set_content(controls.details, page)
        if plan is not None:
            controls.set_content(controls.warnings, warning_list(plan.warnings))
            controls.set_content(controls.certificate, certificate_table(plan, previous=previous))
