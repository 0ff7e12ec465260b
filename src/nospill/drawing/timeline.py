"""A judged motion cut into pictures: everything that changes, at a fixed rate, read from the judge's replay."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import casadi as ca
import numpy as np

from nospill.certification.certificate import Judgement
from nospill.certification.replay import Replay
from nospill.certification.second_order import waves_along
from nospill.core.frames import SX, body_motion
from nospill.core.trees import constants
from nospill.drawing.surfaces import liquid_surface
from nospill.laws.constraints.base import Role
from nospill.laws.constraints.joint_speed import JointSpeed
from nospill.laws.constraints.slosh_height import SloshHeight
from nospill.laws.sample import object_motion
from nospill.laws.scene_parameters import numbers_of, structure_of
from nospill.laws.slosh.residual import free_motion, free_states
from nospill.plans.approach import judged
from nospill.plans.loading import load_plan
from nospill.plans.plan import Plan
from nospill.scene.heights import to_second_order
from nospill.scene.scene import Scene


@dataclass(frozen=True, slots=True)
class LiquidTrack:
    """One liquid over the pictures.

    Attributes:
        coordinates: (m, k + 2 or 3) slosh coordinates in m and leans of the apparent gravity, then what the second
            order adds, m, where heights are judged to it; for `LiquidSurface`.
        height: (m,) greatest rise round the wall, m: the judge's during the motion, by the flow where that is higher
            than the surface drawn, which is of second order at most.
        limit: m.
    """

    coordinates: np.ndarray
    height: np.ndarray
    limit: float


@dataclass(frozen=True, slots=True)
class Film:
    """A motion as pictures.

    Attributes:
        plan: what is shown.
        judgement: where it was read from.
        rate: pictures per second.
        t: (m,) s, from 0, also past the end of the motion.
        end_time: s.
        joint_position: (m, n), rad.
        joint_speed_use: (m, n), speed over its limit, with its sign.
        tray_position: (m, 3) origin of the tray in the base frame, m.
        tray_rotation: (m, 3, 3), tray to base.
        specific_force: (m, 3), tray axes, m/s^2: against the apparent gravity.
        liquids: per object with liquid.
        contact_use: per object on the tray itself, (m,): the largest use of any limit of its contact (slip, tip, ...).
    """

    plan: Plan
    judgement: Judgement
    rate: float
    t: np.ndarray
    end_time: float
    joint_position: np.ndarray
    joint_speed_use: np.ndarray
    tray_position: np.ndarray
    tray_rotation: np.ndarray
    specific_force: np.ndarray
    liquids: dict[str, LiquidTrack]
    contact_use: dict[str, np.ndarray]

    @property
    def length(self) -> float:
        """Time of the last picture, s."""
        return float(self.t[-1])

    def index(self, t: float) -> int:
        """The picture at time t in s; the first or last one outside."""
        return int(np.clip(round((t - float(self.t[0])) * self.rate), 0, len(self.t) - 1))

    def at_rate(self, rate: float) -> Film:
        """The same motion, as long, at another rate."""
        return make_film(self.plan, self.judgement, rate=rate, length=self.length)


def load_films(folders: Sequence[Path], *, rate: float, after_end: float) -> list[Film]:
    """Plan folders, loaded, judged and cut at one rate, all as long as the longest and `after_end` s more.

    Raises:
        PlanFolderError: a folder is not a plan.
    """
    plans = [load_plan(folder) for folder in folders]
    length = max(plan.duration for plan in plans) + after_end
    return [make_film(plan, judged(plan), rate=rate, length=length) for plan in plans]


def make_film(plan: Plan, judgement: Judgement, *, rate: float, length: float | None = None) -> Film:
    """Cut a judged motion into pictures.

    Args:
        plan: the plan.
        judgement: of its trajectory.
        rate: pictures per second.
        length: s, at least that of the motion; after its end the arm stands and the liquids swing freely.
    """
    played, scene = judgement.replay, plan.scene
    start, end = float(played.t[0]), float(played.t[-1])
    t = start + np.arange(int(np.ceil(max(length or 0.0, end - start) * rate - 1e-9)) + 1) / rate
    picked = np.clip(np.rint((t - start) * played.rate).astype(int), 0, len(played.t) - 1)
    after = np.maximum(t - end, 0.0)
    leans = _leans(scene, played.body[:, picked])
    return Film(
        plan=plan,
        judgement=judgement,
        rate=rate,
        t=t - start,
        end_time=plan.duration - start,
        joint_position=played.joint_position[picked],
        joint_speed_use=_joint_speed_use(judgement)[picked],
        tray_position=played.tray.position[picked],
        tray_rotation=played.tray.rotation[picked],
        specific_force=played.body[6:9, picked].T,
        liquids=_to_order(
            _liquids(scene, _coordinates(scene, played, picked, after), leans), scene, judgement, picked, after
        ),
        contact_use=_contact_use(judgement, scene, picked),
    )


def _joint_speed_use(judgement: Judgement) -> np.ndarray:
    traces = [trace for trace in judgement.traces if trace.constraint == JointSpeed.name]
    return np.column_stack([trace.value / np.abs(trace.limit) for trace in traces])


def _liquids(scene: Scene, coordinates: np.ndarray, leans: np.ndarray) -> dict[str, LiquidTrack]:
    tracks = {}
    for number, (cargo, part) in enumerate(zip(scene.cargo, structure_of(scene).slosh_slices, strict=True)):
        if cargo.filling is None:
            continue
        displacement = coordinates[:, part]
        lean = leans[:, 3 * number : 3 * number + 2 + cargo.filling.turns]
        together = np.column_stack([displacement, lean if scene.fidelity == "full" else np.zeros_like(lean)])
        height = liquid_surface(cargo).crest(together)
        tracks[cargo.name] = LiquidTrack(
            together, height, math.inf if cargo.filling.lid else cargo.filling.max_slosh_height
        )
    return tracks


def _to_order(
    liquids: dict[str, LiquidTrack], scene: Scene, judgement: Judgement, picked: np.ndarray, after: np.ndarray
) -> dict[str, LiquidTrack]:
    """The same with what the second order adds, of the liquids that are judged to it, and the judge's heights."""
    played = judgement.replay
    step = 1.0 / played.rate
    later = step * np.arange(1, int(np.ceil(np.max(after) * played.rate)) + 1)
    rest = np.concatenate([np.zeros(6), played.body[6:, -1]])[:, None]
    body = np.concatenate([played.body, np.repeat(rest, len(later), axis=1)], axis=1)
    at = picked + np.rint(after * played.rate).astype(int)
    found, moving = dict(liquids), after == 0.0
    heights = {trace.subject: trace.value for trace in judgement.traces if trace.constraint == SloshHeight.name}
    for cargo, part in zip(scene.cargo, structure_of(scene).slosh_slices, strict=True):
        if not to_second_order(cargo, scene.motion.slosh_height):
            continue
        modes = [(mode.frequency, mode.damping) for mode in cargo.oscillators for _ in mode.directions]
        frequency, damping = np.array(modes).T
        during = played.slosh_displacement[:, part], played.slosh_velocity[:, part]
        free = free_states(frequency, damping, during[0][-1], during[1][-1], later)
        q, qd = (np.concatenate(both) for both in zip(during, free, strict=True))
        waves = waves_along(cargo, body, q, qd, step)
        track, height = liquids[cargo.name], waves.crests[at]
        if cargo.name in heights:
            height[moving] = heights[cargo.name][picked][moving]
        coordinates = np.column_stack([track.coordinates, waves.added[at, 0]])
        found[cargo.name] = replace(track, coordinates=coordinates, height=height)
    return found


def _coordinates(scene: Scene, played: Replay, picked: np.ndarray, after: np.ndarray) -> np.ndarray:
    """Slosh coordinates (m, k), m: the judge's, and after the end each oscillator's own decay."""
    found = played.slosh_displacement[picked].copy()
    later = after > 0.0
    if found.shape[1] and np.any(later):
        found[later] = free_motion(scene, played.slosh_displacement[-1], played.slosh_velocity[-1], after[later])
    return found


def _leans(scene: Scene, body: np.ndarray) -> np.ndarray:
    """Lean a_xy/a_z of the apparent gravity at every object's rest surface, and alpha_z/a_z: (m, 3 per object)."""
    numbers = constants(numbers_of(scene))
    motion = SX.sym("body", 9)
    rows = []
    for object_numbers in numbers.objects:
        at_surface = object_motion(object_numbers, body_motion(motion)).at(
            ca.vertcat(0, 0, object_numbers.liquid_height)
        )
        surface, turn = at_surface.specific_force, at_surface.angular_acceleration[2]
        rows.append(ca.vertcat(surface[:2], turn) / surface[2])
    if not rows:
        return np.zeros((body.shape[1], 0))
    function = ca.Function("leans", [motion], [ca.densify(ca.vertcat(*rows))])
    return np.array(function(ca.DM(body)).full()).T


def _contact_use(judgement: Judgement, scene: Scene, picked: np.ndarray) -> dict[str, np.ndarray]:
    """The largest use over every constraint of the object's contact."""
    found = {cargo.name: np.zeros(len(picked)) for cargo in scene.standing}
    for trace in judgement.traces:
        of_contact = trace.known is not None and trace.known.role is Role.CONTACT
        if of_contact and len(trace.t) > 1 and trace.subject in found:
            found[trace.subject] = np.maximum(found[trace.subject], trace.use[picked])
    return found
