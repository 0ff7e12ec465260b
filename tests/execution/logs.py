"""Logs for the tests: plans as an arm would execute and a recorder write them."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from nospill.execution.log import JointLog
from nospill.plans.plan import Plan


def log_of(
    plan: Plan,
    *,
    clock: float = 0.5,
    delays: np.ndarray | float = 0.0,
    noise: float = 1e-6,
    jitter: float = 2e-5,
    rate: float = 500.0,
) -> JointLog:
    """A plan as it was recorded: the log's clock, delays of the joints (s), noise (rad), jitter of the stamps (s)."""
    generator = np.random.default_rng(3)
    t = np.arange(round((plan.duration + 1.0) * rate)) / rate
    motion = plan.trajectory.motion
    late = np.broadcast_to(delays, len(plan.scene.robot.joints))
    position = np.column_stack([motion(t - clock - own)[:, index] for index, own in enumerate(late)])
    position = position + noise * generator.standard_normal(position.shape)
    stamps = t + jitter * generator.uniform(-1.0, 1.0, len(t))
    return JointLog("run.csv", stamps - stamps[0], plan.scene.robot.joints, position)


def write_log(log: JointLog, place: Path, *, degrees: bool = False, names: list[str] | None = None) -> Path:
    """Write a log as CSV."""
    unit, factor = ("deg", 180.0 / np.pi) if degrees else ("rad", 1.0)
    header = ",".join(["t_s", *(f"{name}_{unit}" for name in names or log.joints)])
    table = np.column_stack([log.t, factor * log.position])
    np.savetxt(place, table, delimiter=",", fmt="%.10f", header=header, comments="")
    return place
