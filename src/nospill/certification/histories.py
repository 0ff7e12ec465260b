"""What the judge saw over time, as arrays: the use of every limit, contact forces, the modes of the liquids."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass
from functools import lru_cache
from typing import Any

import casadi as ca
import numpy as np

from nospill.certification.certificate import Judgement
from nospill.certification.clearance import clearance_traces
from nospill.certification.traces import moving_object
from nospill.certification.verdict import APPROACH, Trace
from nospill.core.batches import evaluate
from nospill.core.frames import SX
from nospill.core.suggestions import nearest
from nospill.core.trees import flatten
from nospill.errors import ScenarioError
from nospill.laws.constraints.base import RowId
from nospill.laws.kinds import numbers_of_object, object_kind
from nospill.laws.scene_parameters import numbers_of, structure_of
from nospill.laws.structure import Structure
from nospill.scene.cargo import Cargo
from nospill.scene.scene import Scene


@dataclass(frozen=True, slots=True)
class History:
    """One limit over the motion, as the certificate judged it.

    Attributes:
        constraint: name of the row.
        subject: of the row.
        unit: of demand, limit and margin.
        t: (m,) the instants that were judged, s; negative in a hold before the motion.
        demand: (m,) what the motion asks for.
        limit: (m,) what it may ask for; of a range the end that is nearer.
        margin: (m,) what is left of the limit, negative where it is broken.
        use: (m,) of the limit, 1 at the limit.
        variant: numbers of the object or speed of the motion that it is about, as in the row; empty as stated.
    """

    constraint: str
    subject: str
    unit: str
    t: np.ndarray
    demand: np.ndarray
    limit: np.ndarray
    margin: np.ndarray
    use: np.ndarray
    variant: str = ""


@dataclass(frozen=True, slots=True)
class ContactLoad:
    """What the tray exerts on an object, in object axes (container frame), about the centre of its bottom.

    Attributes:
        t: (m,) the instants that were judged, s.
        force: (m, 3), N; its z presses and is positive.
        moment: (m, 3), N m.
    """

    t: np.ndarray
    force: np.ndarray
    moment: np.ndarray


@dataclass(frozen=True, slots=True)
class ModalStates:
    """Slosh modes of a liquid, in container axes, mode by mode, x before y; yaw modes last.

    Attributes:
        t: (m,) the instants that were judged, s.
        displacement: (m, k) of the modal masses, m.
        velocity: (m, k), m/s.
    """

    t: np.ndarray
    displacement: np.ndarray
    velocity: np.ndarray


def history_of(judgement: Judgement, scene: Scene, row: RowId) -> History:
    """The history of a row of a certificate; its largest use is that of the row.

    Of a pair of bodies it has the distances at some instants, and the least one at all times where the row has it.

    Raises:
        ScenarioError: the certificate has no such row.
    """
    trace = judgement.fullest.get(row)
    if trace is None:
        trace = _distance(judgement, scene, row)
    return History(*row, trace.unit, trace.t, trace.value, trace.limit, trace.margin, trace.use, trace.variant)


def _distance(judgement: Judgement, scene: Scene, row: RowId) -> Trace:
    rows = judgement.certificate.rows
    of_row = [item for item in rows if item.id == row]
    if not of_row:
        raise ScenarioError(_unknown(row, [item.id for item in rows]))
    played, least = judgement.replay, of_row[0]
    (trace,) = clearance_traces(
        scene, played.t, played.joint_position, of_row, listed={item.subject for item in rows if item is not least}
    )
    at = np.searchsorted(trace.t, least.at_s)
    t, value = np.insert(trace.t, at, least.at_s), np.insert(trace.value, at, least.worst_value)
    return Trace(*row, trace.unit, t, value, np.full(len(t), least.limit), value - least.limit, least.variant)


def _unknown(row: RowId, known: Collection[RowId]) -> str:
    if row.constraint.startswith(APPROACH):
        return f"{row.constraint!r} is judged on the way to the start, of which the certificate has the worst instants"
    constraints = dict.fromkeys(item.constraint for item in known)
    if row.constraint not in constraints:
        return f"no history {row.constraint!r}{_among(row.constraint, constraints)}"
    subjects = [item.subject for item in known if item.constraint == row.constraint]
    return f"no history {row.constraint!r} of {row.subject!r}{_among(row.subject, subjects)}"


def _among(name: str, known: Collection[str]) -> str:
    """What follows a name that is not known: the nearest one, and all of them."""
    near = nearest(name, known)
    return f"{f': did you mean {near!r}?' if near else ';'} there are {', '.join(known)}"


def contact_load(judgement: Judgement, scene: Scene, name: str) -> ContactLoad:
    """Force and moment of the tray on an object, from the law of its constraints on contact.

    Raises:
        ScenarioError: there is no such object, or it stands in another one.
    """
    index, cargo = _object(scene, name, [item.name for item in scene.cargo if not item.carrier])
    if cargo.carrier:
        raise ScenarioError(f"{name!r} moves with {cargo.carrier!r}, in which it stands: ask for {cargo.carrier!r}")
    structure, played = structure_of(scene), judgement.replay
    modes = structure.slosh_slices[index]
    columns = [played.body, played.slosh_displacement.T[modes], played.slosh_velocity.T[modes]]
    numbers = flatten(numbers_of_object(numbers_of(scene), index))
    rows = evaluate(_wrench(object_kind(structure, structure.objects[index])), columns, numbers)
    return ContactLoad(played.t, rows[:3].T.copy(), rows[3:].T.copy())


def modal_states(judgement: Judgement, scene: Scene, name: str) -> ModalStates:
    """The modes of an object's liquid as the judge integrated them.

    Raises:
        ScenarioError: there is no such object, or it holds no liquid.
    """
    filled = [item.name for item in scene.cargo if item.filling]
    index, cargo = _object(scene, name, filled)
    if cargo.filling is None:
        among = f"there are liquids in {', '.join(filled)}" if filled else "nor does any other object"
        raise ScenarioError(f"{name!r} holds no liquid; {among}")
    played, modes = judgement.replay, structure_of(scene).slosh_slices[index]
    return ModalStates(played.t, played.slosh_displacement[:, modes], played.slosh_velocity[:, modes])


def _object(scene: Scene, name: str, known: Collection[str]) -> tuple[int, Cargo]:
    for index, cargo in enumerate(scene.cargo):
        if cargo.name == name:
            return index, cargo
    raise ScenarioError(f"no object {name!r}{_among(name, known)}")


@lru_cache(maxsize=16)
def _wrench(kind: Structure) -> Any:
    """(columns of `Inputs` of one object, `numbers_of_object`) -> force and moment (6, 1)."""
    inputs, sample = moving_object(kind)
    wrench = sample.objects[0].wrench
    return ca.Function("wrench", inputs, [ca.densify(SX(ca.vertcat(wrench.force, wrench.moment)))], {"cse": True})
