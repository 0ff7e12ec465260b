"""Plans of a Franka Research 3, drawn, and the checker of a simulator that others wrote, stepped without clocks."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from importlib import import_module
from types import MappingProxyType
from typing import Any

import numpy as np

from nospill.errors import NospillError
from nospill.planning.planner import plan
from nospill.plans.plan import Plan
from nospill.scenario import scene_from_table

SEED = 54
_STILL = 5
"""Positions before and after a motion."""

_CUP = {"shape": "cylinder", "radius": 0.035, "height": 0.099, "liquid": "water", "empty_mass": 0.1}
_SOLID = {"shape": "cylinder", "radius": 0.03, "height": 0.1, "mass": 0.3}


def drawn_tables(seed: int = SEED) -> Iterator[dict[str, Any]]:
    """Scenarios without end: a cup or a solid on a line in front of the arm, level or tilting, as the seed says."""
    draw = np.random.default_rng(seed)
    while True:
        x, z, drop = draw.uniform(0.35, 0.5), draw.uniform(0.3, 0.6), draw.uniform(-0.1, 0.1)
        yaw, side = draw.uniform(-60.0, 60.0), draw.choice([-1.0, 1.0])
        start, end = side * draw.uniform(0.2, 0.35), -side * draw.uniform(0.2, 0.35)
        cup = {**_CUP, "liquid_height": draw.uniform(0.03, 0.06), "max_slosh_height": 0.015}
        thing = cup if draw.random() < 0.5 else _SOLID
        yield {
            "robot": {"model": "franka-fr3", "limits": {"speed_scale": float(draw.choice([0.6, 0.8, 1.0]))}},
            "tray": {"size": [0.22, 0.17], "friction": 0.45, "friction_reserve": 0.1, "mass": 0.3, "offset": 0.08},
            "cargo": [{"name": "c1", "at": [0.0, 0.0], **thing}],
            "path": {
                "type": "line",
                "start": [x, start, z],
                "end": [x, end, z + drop],
                "yaw": ["0 deg", f"{yaw} deg"],
            },
            "motion": {"tilt": str(draw.choice(["free", "fixed"])), "end": "residual"},
        }


def drawn_plans(
    count: int, controller: dict[str, Any], seed: int = SEED, also: Mapping[str, Any] = MappingProxyType({})
) -> Iterator[tuple[dict[str, Any], Plan]]:
    """The first drawn scenarios that a motion is found for, and their certified plans with a `[controller]`.

    `also` are other tables of each scenario.
    """
    found = 0
    for table in drawn_tables(seed):
        try:
            made = plan(scene_from_table({**table, "controller": controller, **also}, name="drawn"))
        except NospillError:  # out of reach
            continue
        if made.certificate.ok:
            yield table, made
            found += 1
        if found == count:
            return


def violations(q: np.ndarray) -> list[str]:
    """What the checker of franka-sim says of positions of the joints (m, 7), rad, one each 1 ms, from rest to rest.

    The arm does what it is asked for, a cycle later.
    """
    modes, limits = (import_module(f"franka_sim.{name}") for name in ("control_modes", "limits.checker"))
    still = ((_STILL, _STILL), (0, 0))
    asked, zeros = np.pad(q, still, mode="edge"), [0.0] * 7
    speed = np.diff(asked, axis=0, prepend=asked[:1]) / 1e-3
    checker = limits.MotionLimitChecker(enforce=True)
    start = {"q": list(asked[0]), "q_d": list(asked[0]), "dq_d": zeros, "ddq_d": zeros, "tau_J_d": zeros}
    checker.start_motion(modes.ControlMode.POSITION, start)
    said = []
    for cycle, position in enumerate(asked):
        before = max(cycle - 1, 0)
        command = {
            "message_id": cycle + 1,
            "q_c": list(position),
            "dq_c": zeros,
            "O_T_EE_c": [0.0] * 16,
            "O_dP_EE_c": [0.0] * 6,
            "elbow_c": [0.0, 0.0],
            "valid_elbow": False,
            "tau_J_d": zeros,
            "torque_command": False,
            "motion_generation_finished": False,
        }
        checker.note_published(cycle + 1)
        measured = checker.check_measured_velocity(list(asked[before]), list(speed[before]))
        found = (measured, checker.check(command, list(position)))
        checker.record(command)
        said += [f"{cycle - _STILL} ms: {item.describe()}" for item in found if item is not None]
    return said
