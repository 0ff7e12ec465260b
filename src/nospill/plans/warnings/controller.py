"""Warnings about what follows a command: a controller that stops the arm, a tray that is not where it should be."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from nospill.certification.path_deviation import nearest_on
from nospill.certification.record_checks import ATTITUDE_TOLERANCE, POSITION_TOLERANCE
from nospill.plans.warnings.record import Facts, PlanWarning


def behind_the_command(facts: Facts) -> Iterator[PlanWarning]:
    """A joint is farther behind its command than the controller tolerates.

    The command at t is what the joint does one delay later plus its speed there times the lag.
    """
    controller = facts.scene.controller
    if controller is None or controller.tracking_tolerance is None:
        return
    played = facts.judgement.replay
    for joint, name in enumerate(facts.scene.robot.joints):
        position, speed = played.joint_position[:, joint], played.joint_speed[:, joint]
        later = played.t + controller.delay[joint]
        command = np.interp(later, played.t, position) + controller.lag[joint] * np.interp(later, played.t, speed)
        behind = np.abs(command - position)
        most, allowed = float(np.max(behind)), float(controller.tracking_tolerance[joint])
        if most > allowed:
            at = float(played.t[int(np.argmax(behind))])
            text = (
                f"is {1e3 * most:.3g} mrad behind its command at t = {at:.3f} s, and the controller tolerates "
                f"{1e3 * allowed:.3g} mrad (controller.tracking_tolerance): it may stop; raise its tolerance, or slow "
                "the motion down with motion.duration."
            )
            yield PlanWarning("tracking", name, text, most, allowed)


def deviation_from_command(facts: Facts) -> Iterator[PlanWarning]:
    """The command is not compensated, and the tray that follows it leaves the path or leans where it is to be level.

    The rows about path and attitude are of the command; the distance here is that from the nearest place on the path.
    """
    scene, controller = facts.scene, facts.scene.controller
    if controller is None or controller.compensate:
        return
    tray, t = facts.judgement.replay.tray, facts.judgement.replay.t
    advice = (
        'rows "with its command" are of the command, and no row limits this; compensate = true makes the tray do what '
        "is planned"
    )
    if scene.motion.corridor is None:
        distance = nearest_on(scene.path, tray.position)[1]
        at = int(np.argmax(distance))
        if distance[at] > POSITION_TOLERANCE:
            place = f"{1e3 * distance[at]:.2g} mm off its path (t = {t[at]:.3f} s)"
            text = f"the tray that follows is up to {place}: {advice}."
            yield PlanWarning("off the path", "tray", text, float(distance[at]), POSITION_TOLERANCE)
    if not scene.motion.tilt_free:
        lean = np.arcsin(np.clip(np.linalg.norm(tray.rotation[:, 2, :2], axis=1), 0.0, 1.0))
        at = int(np.argmax(lean))
        if lean[at] > ATTITUDE_TOLERANCE:
            text = (
                f"the tray that follows leans by up to {np.degrees(lean[at]):.2g} deg (t = {t[at]:.3f} s), where it is "
                f"asked to be level: {advice}."
            )
            yield PlanWarning("not level", "tray", text, float(lean[at]), ATTITUDE_TOLERANCE)
