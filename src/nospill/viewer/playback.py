"""Playing: a clock, and the controls in the browser that drive it and follow it."""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Sequence
from contextlib import AbstractContextManager
from typing import TYPE_CHECKING

from nospill.drawing.views import VIEW_NAMES, View
from nospill.viewer.charts import Charts, colour_key
from nospill.viewer.scene_view import PlanView

if TYPE_CHECKING:
    import viser

SPEEDS = {"0.1x": 0.1, "0.25x": 0.25, "0.5x": 0.5, "1x": 1.0, "2x": 2.0}
"""Speeds of playing, by label."""
START_SPEED = "0.25x"
"""Of a player that starts: in real time a motion is over before it is seen."""

_CONTROLS_EVERY = 0.08
"""s between two updates of slider and cursor, which cost the browser more than the scene does."""


class Clock:
    """Time of the motion, s, from 0 to `length`; `advance` moves it on while `playing`."""

    def __init__(self, length: float) -> None:
        self.length = length
        self.t = 0.0
        self.playing = True
        self.speed = 1.0
        self.loop = True

    def advance(self, seconds: float) -> None:
        """Let real time pass: at the end start again, or stop there."""
        if not self.playing:
            return
        self.t += self.speed * seconds
        if self.t > self.length:
            if self.loop:
                self.t = self.t % self.length if self.length > 0 else 0.0
            else:
                self.t, self.playing = self.length, False

    def toggle(self) -> None:
        """Play or pause; at the end play from the start."""
        if not self.playing and not self.loop and self.t >= self.length:
            self.t = 0.0
        self.playing = not self.playing

    def seek(self, t: float) -> None:
        """Go to a time and stay there."""
        self.t, self.playing = min(max(t, 0.0), self.length), False


class Player:
    """Controls of one or several plans on one clock, in a `viser.GuiApi` of a server or of one client.

    Call `run` in a thread of its own, or `step` from a loop.
    """

    def __init__(
        self,
        gui: viser.GuiApi,
        views: Sequence[PlanView],
        *,
        charts: Charts,
        atomic: Callable[[], AbstractContextManager[None]],
        aim: Callable[[View], bool] | None = None,
        named: bool = True,
    ) -> None:
        """Add the controls.

        Args:
            gui: where to; they go into its current container.
            views: what is played.
            charts: drawn below the controls.
            atomic: of the server or client, so that a picture arrives whole.
            aim: sees everything from another view, and says whether there is space for names; where there is none,
                there are no buttons for it.
            named: whether names are shown at first.
        """
        self._views, self._charts, self._atomic = views, charts, atomic
        self.clock = Clock(charts.length)
        self._lock = threading.Lock()
        self._controls_due = 0.0
        self.clock.speed = SPEEDS[START_SPEED]
        self._looks = None if aim is None else gui.add_button_group("View", tuple(VIEW_NAMES.values()))
        self._aim = aim
        self._button = gui.add_button("Pause")
        self._slider = gui.add_slider("Time [s]", 0.0, round(charts.length, 3), 0.001, 0.0)
        self._speed = gui.add_dropdown("Speed", tuple(SPEEDS), initial_value=START_SPEED)
        self._loop = gui.add_checkbox("Loop", True)
        self._names = gui.add_checkbox("Names", named)
        self._path = gui.add_checkbox("Path", True)
        self._page = gui.add_html(_page(charts))
        self._cursor = gui.add_html("")
        self._handles = (
            *(() if self._looks is None else (self._looks,)),
            self._button,
            self._slider,
            self._speed,
            self._loop,
            self._names,
            self._path,
            self._page,
            self._cursor,
        )
        self._connect()

    def _connect(self) -> None:
        """Let the controls do what they say; values that this side sets carry no client and are passed over."""

        @self._button.on_click
        def _(_event: object) -> None:
            with self._lock:
                self.clock.toggle()
            self._label()

        @self._slider.on_update
        def _(event: viser.GuiEvent[viser.GuiSliderHandle[float]]) -> None:
            if event.client is not None:
                with self._lock:
                    self.clock.seek(float(event.target.value))
                self._label()

        if self._looks is not None:

            @self._looks.on_click
            def _(event: viser.GuiEvent[viser.GuiButtonGroupHandle]) -> None:
                assert self._aim is not None
                with self._lock:
                    chosen = next(view for view, name in VIEW_NAMES.items() if name == event.target.value)
                    named = self._aim(chosen)
                self._names.value = named  # which calls the function below, so not under the lock

        @self._speed.on_update
        def _(_event: object) -> None:
            with self._lock:
                self.clock.speed = SPEEDS[self._speed.value]

        @self._loop.on_update
        def _(_event: object) -> None:
            with self._lock:
                self.clock.loop = self._loop.value

        @self._names.on_update
        @self._path.on_update
        def _(_event: object) -> None:
            with self._lock:
                self._show_wanted()

    def _label(self) -> None:
        self._button.label = "Pause" if self.clock.playing else "Play"

    def step(self, seconds: float) -> None:
        """Let real time pass and show where the clock is then."""
        with self._lock, self._atomic():
            self.clock.advance(seconds)
            t = self.clock.t
            for view in self._views:
                view.show(t)
            self._controls_due -= seconds
            if self._controls_due <= 0.0 or not self.clock.playing:
                self._controls_due = _CONTROLS_EVERY
                self._slider.value = round(t, 3)
                self._cursor.content = f"<style>{self._charts.cursor_style(t)}</style>"
                self._label()

    def replace(self, views: Sequence[PlanView], *, charts: Charts) -> None:
        """Play other views from their start, at the same speed; the old ones may be removed after this."""
        with self._lock, self._atomic():
            self._views, self._charts = views, charts
            self.clock.length, self.clock.t, self.clock.playing = charts.length, 0.0, True
            self._slider.value = 0.0
            self._slider.max = round(charts.length, 3)
            self._page.content = _page(charts)
            self._show_wanted()

    def _show_wanted(self) -> None:
        """Show or hide names and path in every view."""
        for view in self._views:
            view.tray.show_names(self._names.value)
            view.show_path(self._path.value)

    def run(self, stop: threading.Event) -> None:
        """Play in real time until `stop` is set; a picture that comes late is left out, time goes on."""
        last = time.monotonic()
        period = 1.0 / max(view.film.rate for view in self._views)
        while not stop.wait(max(0.0, last + period - time.monotonic())):
            now = time.monotonic()
            self.step(now - last)
            last = now

    def remove(self) -> None:
        """Take the controls away."""
        for handle in self._handles:
            handle.remove()


def _page(charts: Charts) -> str:
    return f"<div style='padding:4px 8px 0 4px'>{colour_key()}{charts.page}</div>"
