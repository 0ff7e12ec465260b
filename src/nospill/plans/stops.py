"""Stops of a plan as records: the spill-free stop at every instant, and what the controller's own stop does."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, Literal

import numpy as np

from nospill.certification.happening import CONTACT_VERBS
from nospill.motion.interpolation import JointSamples
from nospill.motion.trajectory import Trajectory

_FEW = 2
"""Objects that are named; more are counted."""

Origin = Literal["solved", "later", "rest of the plan"]


@dataclass(frozen=True, slots=True)
class Bound:
    """A time, s, in which no motion from a state comes to rest, and what sets it."""

    duration: float
    by: str


NO_BOUND = Bound(0.0, "nothing")


@dataclass(frozen=True, slots=True)
class Stop:
    """The fastest certified stop that was found from an instant of a plan.

    Attributes:
        t: s, when it begins, on the plan's clock.
        duration: s, until the arm stands.
        left: s, what is left of the plan.
        end: path parameter at which the tray comes to rest.
        origin: whether it was solved, or the plan goes on to a later instant and that one's stop follows, or it is what
            is left of the plan, which is always one.
        nearest: the row of its certificate that is nearest to its limit, in words.
        trajectory: its samples, on a clock that begins with it.
        seconds: what finding and judging it took, s.
        bound: in what time no motion from there comes to rest.
        doubted: liquids whose nonlinear flow, which judges their crests, is in doubt in this stop: its surface is
            steeper than 45 deg, where standing waves break. Of what is left of the plan its own warnings say so.
    """

    t: float
    duration: float
    left: float
    end: float
    origin: Origin
    nearest: str
    trajectory: Trajectory = field(repr=False)
    seconds: float
    bound: Bound
    doubted: tuple[str, ...] = ()

    @property
    def is_sooner(self) -> bool:
        """Whether it is sooner than what is left of the plan."""
        return self.origin != "rest of the plan"


@dataclass(frozen=True, slots=True)
class ControllerStop:
    """What a stop by the controller does from an instant of a plan, which knows nothing of what is on the tray.

    Attributes:
        t: s, when it begins.
        kind: "joints": each joint brakes by itself; "path": time is scaled to zero along the path.
        duration: s, until the arm stands.
        certified: whether every limit holds.
        spill: m, of the liquid that is highest above its `max_slosh_height`; 0 where none is, infinite where one is
            beyond what can be integrated, or its flow breaks down.
        uses: largest use of a limit by "constraint | subject", of those on objects and liquids that are broken.
    """

    t: float
    kind: Literal["joints", "path"]
    duration: float
    certified: bool
    spill: float
    uses: Mapping[str, float]

    @property
    def text(self) -> str:
        """What it does, in words: "crest 6 mm too high, slides c2", or "holds"."""
        if self.certified:
            return "holds"
        parts = ["beyond the slosh model"] if math.isinf(self.spill) else []
        if 0.0 < self.spill < math.inf:
            parts.append(f"crest {1e3 * self.spill:.0f} mm too high")
        for constraint, verb in CONTACT_VERBS.items():
            names = sorted(key.partition(" | ")[2] for key in self.uses if key.partition(" | ")[0] == constraint)
            if names:
                parts.append(f"{verb} {', '.join(names) if len(names) <= _FEW else len(names)}")
        return ", ".join(parts) or "a limit of the arm, or swings on"


@dataclass(frozen=True, slots=True)
class Stops:
    """Every stop of a plan.

    Attributes:
        plan: name of its scene.
        duration: s, of its motion.
        stops: at every instant, in the order of time.
        controller: the controller's own stops from the same instants.
        deceleration: (n,) rad/s^2, with which each joint brakes there.
        slowing: s, in which time is scaled to zero there.
        residual: how high liquids may swing on after a stop, over max_slosh_height.
    """

    plan: str
    duration: float
    stops: tuple[Stop, ...]
    controller: tuple[ControllerStop, ...]
    deceleration: tuple[float, ...]
    slowing: float
    residual: float

    @property
    def solved(self) -> float:
        """Part of the instants at which a stop sooner than the rest of the plan was found."""
        return float(np.mean([stop.is_sooner for stop in self.stops]))

    @property
    def part_left(self) -> float:
        """Median of stopping time over what is left of the plan, from one to two thirds of the motion."""
        return float(np.median([stop.duration / stop.left for stop in self._middle]))

    @property
    def bound_of_left(self) -> float:
        """The same of the bound on stopping times: no stops have a smaller part."""
        return float(np.median([stop.bound.duration / stop.left for stop in self._middle]))

    @property
    def over_bound(self) -> float:
        """Median there of stopping time over its bound."""
        return float(np.median([stop.duration / max(stop.bound.duration, 1e-9) for stop in self._middle]))

    @property
    def doubt(self) -> str | None:
        """Of which liquids in how many stops the nonlinear flow is in doubt, as a sentence; None where of none."""
        doubted = [stop for stop in self.stops if stop.doubted]
        if not doubted:
            return None
        names = sorted({name for stop in doubted for name in stop.doubted})
        return (
            f"in {len(doubted)} of {len(self.stops)} stops the flow that judges {', '.join(names)} is in doubt: its "
            "surface is steeper than 45 deg, where standing waves break; try a smaller max_slosh_height"
        )

    @property
    def longest(self) -> Stop:
        """The stop that takes longest."""
        return max(self.stops, key=lambda stop: stop.duration)

    @property
    def _middle(self) -> tuple[Stop, ...]:
        """The stops from one to two thirds of the motion; all of them where none is."""
        middle = tuple(stop for stop in self.stops if 1 / 3 <= stop.t / self.duration <= 2 / 3)
        return middle or self.stops

    def to_dict(self) -> dict[str, Any]:
        """As stops.json has it."""
        return {
            "plan": self.plan,
            "duration_s": self.duration,
            "solved": self.solved,
            "median_of_rest": self.part_left,
            "median_bound_of_rest": self.bound_of_left,
            "longest_stop": {"t_s": self.longest.t, "stops_in_s": self.longest.duration},
            "deceleration_rad_s2": list(self.deceleration),
            "slowing_s": self.slowing,
            "residual_fraction": self.residual,
            "stops": [
                {
                    "t_s": stop.t,
                    "stops_in_s": stop.duration,
                    "left_s": stop.left,
                    "s_end": stop.end,
                    "bound_s": stop.bound.duration,
                    "bound_by": stop.bound.by,
                    "origin": stop.origin,
                    "nearest": stop.nearest,
                    "flow_in_doubt": list(stop.doubted),
                    "file": file_of(stop) if stop.is_sooner else None,
                }
                for stop in self.stops
            ],
            "controller": [
                {
                    "t_s": item.t,
                    "kind": item.kind,
                    "stops_in_s": item.duration,
                    "certified": item.certified,
                    "over_max_slosh_height_m": None if math.isinf(item.spill) else item.spill,
                    "broken": dict(item.uses),
                    "text": item.text,
                }
                for item in self.controller
            ],
        }


def file_of(stop: Stop) -> str:
    """Name of the file with the samples of a stop, after the instant in ms."""
    return f"stop-{round(1e3 * stop.t):06d}.csv"


def stopped(record: Trajectory, stop: Stop) -> JointSamples:
    """The joints of a plan until an instant and of the stop from there, as one motion from rest to rest: positions."""
    rows = round((stop.t - record.t[0]) * record.rate)
    q = np.concatenate([record.joint_position[:rows], stop.trajectory.joint_position])
    return JointSamples(np.arange(len(q)) / record.rate, q)
