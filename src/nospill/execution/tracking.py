"""Executed motion compared with its command: the two clocks, the delay of every joint, the distance on the way."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from nospill.errors import ScenarioError
from nospill.execution.motion import REST, RecordedMotion
from nospill.motion.interpolation import JointMotion
from nospill.robots.kinematics.forward import kinematics
from nospill.scene.scene import Scene

_STEP = 0.002
"""s; at these instants positions are compared."""
_ROUNDS = 12
_LEAST_TRAVEL = 0.01
"""rad; of a joint that moves by less no delay can be told."""
_OTHER = 0.2
"""rad; a joint that is farther from its plan, when it stands or on the way, follows another one."""


@dataclass(frozen=True, slots=True, eq=False)
class Tracking:
    """Executed joints against what was asked for.

    Attributes:
        clock: time of the log at which the plan begins, as it was executed, s: a delay that all joints have in common
            is in it. Zero where the log itself has what was asked for.
        delay: (n,) of every joint, s: against this clock, or against the command in the log; NaN where it hardly moves.
        of_command: whether the delays are against the command in the log, that is in full.
        error: (n,) largest distance of executed and asked positions on this clock, rad.
        error_at: (n,) when, s.
        tray_error: largest distance of the tray from where it should be, m.
        tray_error_at: when, s.
    """

    clock: float
    delay: np.ndarray
    of_command: bool
    error: np.ndarray
    error_at: np.ndarray
    tray_error: float
    tray_error_at: float


def tracking(recorded: RecordedMotion, scene: Scene, planned: JointMotion, duration: float) -> Tracking:
    """Compare a log with the plan it is of.

    Args:
        recorded: the log.
        scene: with the robot and its tray.
        planned: the joints of the plan, from 0 s on.
        duration: of the plan, s.

    Raises:
        ScenarioError: the log is of another motion, or its joints are counted from another zero.
    """
    executed = recorded.held()
    _check_start(recorded, planned)
    t = np.arange(0.0, duration + _STEP, _STEP)
    first = float(t[np.argmax(np.max(np.abs(planned(t, 1)), axis=1) > REST)])
    clock = float(delays(executed, planned, t, recorded.begin - first, together=True)[0])
    compared = _compare(executed, planned, t, clock, scene)
    worst = int(np.argmax(compared.error))
    if compared.error[worst] > _OTHER:
        raise ScenarioError(
            f"{recorded.log.origin}: {scene.robot.joints[worst]} is {compared.error[worst]:.3g} rad from the plan at "
            f"t = {compared.error_at[worst]:.3f} s: the log of another motion; give the plan that was executed"
        )
    return compared


def track_command(recorded: RecordedMotion, scene: Scene, command: JointMotion) -> Tracking:
    """Compare a log with the command that it has itself, on one clock."""
    t = np.arange(recorded.begin, recorded.end, _STEP)
    return _compare(recorded.held(), command, t, 0.0, scene, of_command=True)


def delays(
    executed: JointMotion, asked: JointMotion, t: np.ndarray, start: float, *, together: bool = False
) -> np.ndarray:
    """Delays d with the least sum of squares of executed(t + d) - asked(t), by Gauss-Newton steps, s.

    Args:
        executed: the motion behind.
        asked: the motion before.
        t: (m,) s.
        start: of the search, s.
        together: one for all joints, (1,); else one each, (n,).
    """
    wanted = asked(t)
    delay = np.full(wanted.shape[1], start)
    for _ in range(_ROUNDS):
        columns = range(len(delay))
        place = [executed(t + delay[j])[:, j] for j in columns] if not together else executed(t + delay[0]).T
        speed = [executed(t + delay[j], 1)[:, j] for j in columns] if not together else executed(t + delay[0], 1).T
        gap, speed = wanted.T - np.array(place), np.array(speed)
        up, down = np.sum(gap * speed, axis=1), np.sum(speed**2, axis=1)
        if together:
            up, down = np.full_like(up, np.sum(up)), np.full_like(down, np.sum(down))
        step = np.where(down > 0.0, up / np.where(down > 0.0, down, 1.0), 0.0)
        delay = delay + step
        if np.max(np.abs(step)) < 1e-9:
            break
    return delay[:1] if together else delay


def _compare(
    executed: JointMotion, asked: JointMotion, t: np.ndarray, clock: float, scene: Scene, *, of_command: bool = False
) -> Tracking:
    wanted, done = asked(t), executed(t + clock)
    delay = delays(executed, asked, t, clock) - clock
    delay[np.ptp(wanted, axis=0) < _LEAST_TRAVEL] = np.nan
    error = np.abs(done - wanted)
    still = np.zeros_like(wanted)
    places = [kinematics(scene.robot).motions(q, still, still, tool=scene.tray.tool).position for q in (done, wanted)]
    distance = np.linalg.norm(places[0] - places[1], axis=1)
    at = int(np.argmax(distance))
    return Tracking(
        clock=clock,
        delay=delay,
        of_command=of_command,
        error=np.max(error, axis=0),
        error_at=t[np.argmax(error, axis=0)],
        tray_error=float(distance[at]),
        tray_error_at=float(t[at]),
    )


def _check_start(recorded: RecordedMotion, planned: JointMotion) -> None:
    """Before the motion every joint is where the plan begins."""
    off = recorded.smooth(np.array([recorded.begin]))[0] - planned(np.array([0.0]))[0]
    worst = int(np.argmax(np.abs(off)))
    if abs(off[worst]) > _OTHER:
        name = recorded.log.joints[worst]
        raise ScenarioError(
            f"{recorded.log.origin}: {name} is {np.degrees(off[worst]):.4g} deg from where the plan begins: the log "
            f'of another plan, or counted from another zero (--offset {name}="{-np.degrees(off[worst]):.4g} deg")'
        )
