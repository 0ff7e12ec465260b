"""Warning about a controller that stops the arm because it is too far behind its command."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

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
