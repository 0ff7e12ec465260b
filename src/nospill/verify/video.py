"""A film of the simulation: tray and liquids as the judge has them, the objects where the engine has them."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
from scipy.spatial.transform import Rotation

from nospill.certification.certificate import judge
from nospill.drawing.props import Placed
from nospill.drawing.timeline import make_film
from nospill.film.writing import Format, save_film
from nospill.plans.plan import Plan
from nospill.verify.engine import build, simulate
from nospill.verify.tray_motion import PlayedJoints
from nospill.verify.verification import AFTER, stage


def write_film(
    plan: Plan,
    joints: PlayedJoints,
    path: Path,
    form: Format | None = None,
    *,
    progress: Callable[[int, int], None] | None = None,
) -> int:
    """Simulate as `verify` does and film it, settling left out.

    Args:
        plan: whose objects.
        joints: the motion of the robot.
        path: film to write, at once or not at all.
        form: how it looks.
        progress: called with the number of pictures drawn and that of all.

    Returns:
        The number of pictures.

    Raises:
        As `nospill.film.writing.save_film`; MissingExtraError: MuJoCo is not installed.
    """
    used = form or Format()
    judged = judge(plan.trajectory, plan.scene)
    film = make_film(plan, judged, rate=used.motion_rate, length=plan.duration + AFTER)
    return save_film([film], path, used, placed=simulated(plan, joints, film.t), progress=progress)


def simulated(plan: Plan, joints: PlayedJoints, t: np.ndarray) -> dict[str, Placed]:
    """Where the engine has every object at times t (m,) in s from the start of the motion; after its end the last."""
    scene = stage(joints, plan.scene)
    run = simulate(build(scene.bodies), scene.bodies, scene.motion)
    clock = run.t - run.t[scene.settled]
    wanted = np.clip(np.searchsorted(clock, t - 1e-9), scene.settled, len(clock) - 1)
    return {
        body.name: Placed(
            run.position[wanted, number],
            Rotation.from_quat(run.quaternion[wanted, number][:, [1, 2, 3, 0]]).as_matrix(),
        )
        for number, body in enumerate(scene.bodies)
    }
