"""The last plan as it moves: built once it is there, replaced by the next one, hidden while the tray is laid out."""

from __future__ import annotations

import threading
from typing import TYPE_CHECKING, Any

from nospill.certification.certificate import judge
from nospill.drawing.timeline import make_film
from nospill.plans.plan import Plan
from nospill.viewer.charts import draw_charts
from nospill.viewer.live import short_titles
from nospill.viewer.playback import Player
from nospill.viewer.scene_view import PlanView

if TYPE_CHECKING:
    import viser

RATE = 30.0
"""Pictures per second: fewer than the viewer's, as planning and several tabs share the machine."""
_AFTER_END = 0.5
"""s; how long the liquids are shown after the motion."""
_LAST_MOMENT = 2.0
"""s; how long closing waits for the player."""


class MotionView:
    """Scene and player of one plan in one client.

    Attributes:
        plan: the last one, or None.
    """

    def __init__(self, client: viser.ClientHandle, tab: Any) -> None:
        """Nothing is shown yet; the player will be added to `tab`, a container of viser."""
        self._client, self._tab = client, tab
        self.plan: Plan | None = None
        self._view: PlanView | None = None
        self._player: Player | None = None
        self._number = 0
        self._stop = threading.Event()
        self._thread: threading.Thread | None = None

    @property
    def shown(self) -> bool:
        """Whether the motion is to be seen."""
        return self._view is not None and self._root().visible

    def take(self, plan: Plan) -> None:
        """Show a plan from its start, in place of the one before; nothing where it is the one shown."""
        if plan is self.plan:
            return
        film = make_film(
            plan,
            plan.judgement or judge(plan.trajectory, plan.scene),
            rate=RATE,
            length=plan.duration + _AFTER_END,
        )
        old, self.plan = self._view, plan
        self._number += 1
        with self._client.atomic():
            self._view = PlanView(self._client.scene, film, root=f"/motion_{self._number}")
        charts = draw_charts([film], short_titles([film]))
        if self._player is None:
            with self._tab:
                self._player = Player(self._client.gui, [self._view], charts=charts, atomic=self._client.atomic)
            self._thread = threading.Thread(target=self._player.run, args=(self._stop,), daemon=True)
            self._thread.start()
        else:
            self._player.replace([self._view], charts=charts)
        if old is not None:
            old.remove()

    def show(self) -> None:
        """Show the plan, if there is one."""
        if self._view is not None:
            self._root().visible = True

    def hide(self) -> None:
        """Stand still and out of sight."""
        if self._view is not None and self._player is not None:
            self._player.clock.playing = False
            self._root().visible = False

    def close(self) -> None:
        """Stop playing for good."""
        self._stop.set()
        if self._thread is not None:
            self._thread.join(_LAST_MOMENT)

    def _root(self) -> Any:
        assert self._view is not None
        return self._client.scene.get_handle_by_name(self._view.root)
