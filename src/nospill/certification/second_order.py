"""Slosh heights to the second order in the place of the linear ones, or the flow's where that is higher, as asked for.

The judge's own waves are the first order, as they are integrated on its grid with the mass of the first mode on its
paraboloid; what they drive is added to their surface round the wall (`potential_flow.driven`). After the end both
orders swing on: the modes freely, and what they have driven at frequencies of its own beside what they still drive.
Forces and everything else stay those of the modes.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from functools import cache

import numpy as np

from nospill.certification.by_flow import Left, crests_by_flow, left_by_flow
from nospill.certification.replay import Replay
from nospill.certification.verdict import Trace
from nospill.certification.wall_heights import INSTANTS, highest_on_wall, linear_heights, of_second_order
from nospill.core.units import as_written
from nospill.errors import ModelError
from nospill.laws.constraints.residual_height import ResidualHeight
from nospill.laws.constraints.slosh_height import SloshHeight
from nospill.laws.scene_parameters import structure_of
from nospill.laws.slosh.residual import free_states
from nospill.potential_flow import STEP_ANGLE, Driven, driven, rows_at, second_order_states
from nospill.scene.cargo import Cargo
from nospill.scene.heights import to_second_order
from nospill.scene.scene import Scene


def with_second_order(traces: Iterable[Trace], scene: Scene, played: Replay) -> tuple[Trace, ...]:
    """The traces, where the scene asks for it those of heights to the second order or by the nonlinear flow.

    Slosh heights have the grid of the replay, residual heights instants from which the tray stands. What a stop leaves
    stays that of the modes.
    """
    liquids, waves, flows = _liquids(scene), dict[str, Waves](), dict[int, dict[str, Left]]()

    @cache  # where no height is judged, the replay may be of the arm alone
    def crests() -> dict[str, np.ndarray]:
        return crests_by_flow(scene, played)

    def left(name: str, index: int) -> float:
        if index not in flows:
            flows[index] = left_by_flow(scene, played, index)
        found = flows[index].get(name)
        return followed_waves(name).highest_after(index, scene.gravity) if found is None else found.highest

    def followed_waves(name: str) -> Waves:
        waves[name] = waves.get(name) or _waves(*liquids[name], played)
        return waves[name]

    def judged(trace: Trace) -> Trace:
        if trace.constraint == SloshHeight.name:
            value, of_flow = followed_waves(trace.subject).crests, crests().get(trace.subject)
            value = value if of_flow is None else np.maximum(value, of_flow)
        else:
            standing = np.clip(np.searchsorted(played.t, trace.t - 0.5 / played.rate), 0, len(played.t) - 1)
            value = np.array([left(trace.subject, int(index)) for index in standing])
        return replace(trace, value=value, margin=np.abs(trace.limit) - value, linear=trace.value)

    heights = {SloshHeight.name, *([ResidualHeight.name] if left_to_second_order(scene) else [])}
    return tuple(
        judged(trace) if trace.constraint in heights and trace.subject in liquids else trace for trace in traces
    )


def left_to_second_order(scene: Scene) -> bool:
    """Whether the height after the end is judged to the second order or more, of the liquids of which it is known."""
    return scene.motion.residual_height != "linear" and not scene.motion.stop


def with_second_order_along(
    traces: Iterable[Trace], scene: Scene, replays: Sequence[Replay], *, step_angle: float
) -> tuple[Trace, ...]:
    """Traces during some replays of one length, one behind the other; slosh heights as the scene asks for them.

    Args:
        traces: of heights as the modes have them.
        scene: whose liquids.
        replays: the motions.
        step_angle: with which the second order is integrated, rad of its fastest mode.
    """
    liquids = _liquids(scene)

    def judged(trace: Trace) -> Trace:
        cargo, modes = liquids[trace.subject]
        body = np.hstack([played.body for played in replays])
        q, qd = (
            np.concatenate([state[:, modes] for state in states])
            for states in zip(*((played.slosh_displacement, played.slosh_velocity) for played in replays), strict=True)
        )
        step = 1.0 / replays[0].rate
        value = waves_along(cargo, body, q, qd, step, motions=len(replays), step_angle=step_angle).crests
        return replace(trace, value=value, margin=np.abs(trace.limit) - value, linear=trace.value)

    return tuple(
        judged(trace) if trace.constraint == SloshHeight.name and trace.subject in liquids else trace
        for trace in traces
    )


def heights_after(scene: Scene, played: Replay, t: np.ndarray) -> dict[str, np.ndarray]:
    """Of liquids that are judged to the second order or more their greatest heights (n,) at even times after it, m."""
    if not left_to_second_order(scene):
        return {}
    found = {name: left.crests(t) for name, left in left_by_flow(scene, played, -1).items()}
    for name, (cargo, modes) in _liquids(scene).items():
        if name not in found:
            found[name] = _waves(cargo, modes, played).after(-1, t, scene.gravity).crests
    return found


def followed(scene: Scene, played: Replay, name: str) -> Waves:
    """A liquid to the second order along a replay, to whatever order its height is judged.

    Args:
        scene: at full fidelity, as it was played.
        played: the motion.
        name: of an object whose second order is known (`unsupported`).
    """
    pairs = zip(scene.cargo, structure_of(scene).slosh_slices, strict=True)
    return next(_waves(cargo, modes, played) for cargo, modes in pairs if cargo.name == name)


def _liquids(scene: Scene) -> dict[str, tuple[Cargo, slice]]:
    """The liquids that are judged to the second order, with the places of their slosh coordinates."""
    pairs = zip(scene.cargo, structure_of(scene).slosh_slices, strict=True)
    order = scene.motion.slosh_height
    return {cargo.name: (cargo, modes) for cargo, modes in pairs if to_second_order(cargo, order)}


def _waves(cargo: Cargo, modes: slice, played: Replay) -> Waves:
    q, qd = played.slosh_displacement[:, modes], played.slosh_velocity[:, modes]
    return waves_along(cargo, played.body, q, qd, 1.0 / played.rate)


@dataclass(frozen=True, slots=True)
class Waves:
    """A liquid to the second order along a motion, at instants (m,).

    Attributes:
        cargo: whose liquid.
        displacement: (m, k) of the modal masses, m.
        velocity: (m, k) likewise, m/s.
        added: (m, 2, J) heights, m, and own velocities, m/s, of the second order in each of its modes, as
            `potential_flow.second_order_states` has them.
        crests: (m,) greatest heights round the wall of a cylinder, or in the corners of a box, above the rest level, m.
    """

    cargo: Cargo
    displacement: np.ndarray
    velocity: np.ndarray
    added: np.ndarray
    crests: np.ndarray

    def after(self, index: int, t: np.ndarray, gravity: float) -> Waves:
        """The same at even times (n,), s, since an instant from which the tray stands level."""
        modes = [(mode.frequency, mode.damping) for mode in self.cargo.oscillators for _ in mode.directions]
        frequency, damping = np.array(modes).T
        free = free_states(frequency, damping, self.displacement[index], self.velocity[index], t)
        rest = np.zeros((9, len(t)))
        rest[8] = gravity
        return waves_along(self.cargo, rest, *free, float(t[1] - t[0]), start=self.added[index])

    def highest_after(self, index: int, gravity: float) -> float:
        """Greatest height in the `INSTANTS` since an instant from which the tray stands level, m."""
        return float(np.max(self.after(index, INSTANTS, gravity).crests))


def waves_along(
    cargo: Cargo,
    body: np.ndarray,
    displacement: np.ndarray,
    velocity: np.ndarray,
    step: float,
    *,
    start: np.ndarray | None = None,
    motions: int = 1,
    step_angle: float = STEP_ANGLE,
) -> Waves:
    """The second order that a liquid's own waves drive.

    Args:
        cargo: whose liquid, at full fidelity.
        body: (9, m) of the tray, as `Replay.body`.
        displacement: (m, k) of the modal masses, m.
        velocity: (m, k) likewise, m/s.
        step: between the instants, s.
        start: (2, J) the second order at the first instant; when left out as the initial swing has it, or at rest.
        motions: how many of one length follow one another in the instants.
        step_angle: largest step of the integration, rad of the fastest mode.

    Raises:
        ModelError: that swing has more modes than the liquid.
    """
    filling = cargo.filling
    assert filling is not None  # `to_second_order` says so
    own = rows_at(body, np.array([*cargo.position, 0.0]), cargo.yaw)
    liquid = driven(cargo)
    begin = _beginning(cargo, liquid) if start is None else start
    added = second_order_states(
        liquid, own, displacement, velocity, step, begin, motions=motions, step_angle=step_angle
    )
    linear, yaw = linear_heights(filling, own, displacement)
    modes = liquid.terms.basin.modes
    crests = highest_on_wall(modes, linear, added[:, 0], of_second_order(cargo, modes)) + yaw
    return Waves(cargo, displacement, velocity, added, crests)


def _beginning(cargo: Cargo, liquid: Driven) -> np.ndarray:
    """(2, J) the second order when a motion begins: as the liquid's initial swing has it, else at rest."""
    begin = np.zeros((2, len(liquid.terms.stiffness)))
    swing = None if cargo.filling is None else cargo.filling.initial_swing
    if swing is not None:
        count = len(swing.second_height)
        if count > begin.shape[1]:
            raise ModelError(
                f"cargo {as_written(cargo.name)}: initial_swing.second_height has {count} modes; its liquid has "
                f"{begin.shape[1]} of second order"
            )
        begin[:, :count] = swing.second_height, swing.second_velocity
    return begin
