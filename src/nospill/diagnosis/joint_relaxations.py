"""Relaxations of the limits of the joints, and of the load that they carry."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

import numpy as np

from nospill.diagnosis.relaxation import MOST, Relaxation, Sensitivities, instead_text, is_main, with_cargo
from nospill.errors import Change, NospillError, Setting
from nospill.laws.constraints.base import JointKey
from nospill.robots.robot import Robot
from nospill.scenario import scene_from_table
from nospill.scene.scene import Scene


def own_robot(scene: Scene) -> Robot | None:
    """The arm with the limits of its own data, without those of the scenario; None where its data have none."""
    robot = scene.source.get("robot")
    assert isinstance(robot, dict)
    bare = {key: value for key, value in robot.items() if key not in ("limits", "limits_applied", "home")}
    table = {key: value for key, value in scene.source.items() if key != "approach"}
    try:
        return scene_from_table(table | {"robot": bare}, name=scene.name).robot
    except NospillError:
        return None


Raised = Callable[[float], np.ndarray]
"""Share -> the limits of all joints."""


def relaxed_joint_limit(
    scene: Scene, limit: JointKey, constraint: str, subject: str, sensitivities: Sensitivities
) -> list[Relaxation]:
    """The scenario's scale of the limit where it has one, else the limit of the joint, or of all joints that need it.

    No limit grows beyond the robot's own.
    """
    key, attribute, dimension = limit.key, limit.attribute, limit.dimension
    now = np.array(getattr(scene.robot, attribute))
    index = scene.robot.joints.index(subject)
    robot = own_robot(scene)
    own = None if robot is None else getattr(robot, attribute)
    limited = np.isfinite(now)  # a joint without a torque limit has an infinite one
    finite = np.where(limited, now, 1.0)
    widening = np.full(len(now), MOST) if own is None else np.where(limited, own, 1.0) / finite - 1.0
    limits = _limits_table(scene)
    scale = limits.get(f"{key}_scale")
    if scale is not None:
        scale = float(np.max(now[limited] / own[limited])) if own is not None and key not in limits else None
    if scale is not None:
        factor = scale

        def rescaled(share: float) -> Change:
            value = factor * (1.0 + share)
            text = instead_text(f"limits.{key}_scale", value, factor, "ratio", subject)
            return Change.of_limit(constraint, subject, f"robot.limits.{key}_scale", value, text)

        def loosened(share: float) -> Scene:
            return _with_limits(scene, attribute, now * (1.0 + share))

        return [Relaxation(constraint, subject, 1.0 / factor - 1.0, rescaled, loosened)]
    # a scale of values that are given too: none of the two alone says what to write; a list has a value for every joint
    if f"{key}_scale" in limits or not limited.all():
        return []
    able = [joint for joint in range(len(now)) if widening[joint] > 1e-6]
    relaxations = []
    for chosen in ([index], able) if is_main(subject, constraint, sensitivities) else (able,):

        def raised(share: float, chosen: list[int] = chosen) -> np.ndarray:
            values = now.copy()
            values[chosen] = np.minimum(now[chosen] * (1.0 + share), now[chosen] * (1.0 + widening[chosen]))
            return values

        def change(share: float, raised: Raised = raised, chosen: list[int] = chosen) -> Change:
            values = raised(share)
            value: Setting = values.tolist()
            whose = subject if len(chosen) == 1 else f"{subject}, the others alike"
            text = instead_text(f"limits.{key}", float(values[index]), float(now[index]), dimension, whose)
            return Change.of_limit(constraint, subject, f"robot.limits.{key}", value, text)

        def stronger(share: float, raised: Raised = raised) -> Scene:
            return _with_limits(scene, attribute, raised(share))

        relaxations.append(Relaxation(constraint, subject, min(float(widening[index]), MOST), change, stronger))
    return relaxations


def _with_limits(scene: Scene, attribute: str, values: np.ndarray) -> Scene:
    return replace(scene, robot=replace(scene.robot, **{attribute: values}))


def _limits_table(scene: Scene) -> dict[str, Any]:
    robot = scene.source.get("robot")
    assert isinstance(robot, dict)
    return robot.get("limits", {})


def lighter_load(scene: Scene, constraint: str, subject: str) -> list[Relaxation]:
    """A lighter heaviest solid, where there is a solid."""
    pairs = enumerate(scene.cargo)
    solids = [index for index, cargo in pairs if cargo.filling is None and cargo.contents is None and not cargo.carrier]
    if not solids:
        return []
    heaviest = max(solids, key=lambda index: scene.cargo[index].total.mass)
    item = scene.cargo[heaviest]

    def lighter(share: float) -> Scene:
        part = 1.0 / (1.0 + share)
        total = replace(item.total, mass=part * item.total.mass, inertia=part * item.total.inertia)
        return with_cargo(scene, [heaviest], lambda item: replace(item, total=total, empty=total))

    def change(share: float) -> Change:
        value = item.total.mass / (1.0 + share)
        text = instead_text("mass", value, item.total.mass, "mass", item.name)
        return Change.of_limit(constraint, subject, f"cargo.{item.name}.mass", value, text)

    return [Relaxation(constraint, subject, MOST, change, lighter)]
