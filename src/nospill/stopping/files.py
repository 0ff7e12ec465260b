"""Stops as files for controllers: written, read back, and judged with the plan before them as they will be played.

Where a format has a place for when a motion begins (the header of a ROS message), that is the time of the instant after
the plan's start. A URScript program holds the plan and a branch to every stop.
"""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from nospill.certification.joining import JOINS
from nospill.certification.verdict import Certificate
from nospill.core.files import atomic_folder
from nospill.errors import PlanFolderError, ScenarioError
from nospill.export import Exporter
from nospill.export.urscript import URSCRIPT
from nospill.export.urscript_stops import read_stopping_program, write_stopping_program
from nospill.motion.interpolation import QUINTIC_SPLINE, Interpolation, JointSamples
from nospill.motion.resampling import resampled, sampled
from nospill.plans.handover import rate_of, read_samples, require_exportable
from nospill.plans.plan import Plan
from nospill.plans.stops import Stop, Stops, stopped
from nospill.scene.scene import Scene
from nospill.stopping.controller import judged_to_rest, scene_to_rest

_ON_GRID = 1e-6
"""Of a period, by which an instant may be off a sample."""


@dataclass(frozen=True, slots=True)
class WrittenStop:
    """A stop in a file, and the verdict on plan and stop as its receiver plays them, from rest to a second of rest."""

    stop: Stop
    path: Path
    certificate: Certificate


def hand_over_stops(
    found: Stops, plan: Plan, exporter: Exporter, path: Path, *, rate: float | None = None
) -> list[WrittenStop]:
    """Write the stops that are sooner than the rest of the plan, read them back and judge them.

    Args:
        found: the stops of the plan.
        plan: from which they begin.
        exporter: the format.
        path: the folder to write, a file for each stop; of URScript the one program.
        rate: samples per second, Hz; the format's usual one or the plan's when left out.

    Raises:
        ScenarioError: the format does not take this arm or rate, or an instant is between its samples.
        PlanFolderError: the disk refuses, or what is read is not what was written.
        ModelError: the liquids cannot be integrated along what was read.
    """
    rate = rate_of(plan, exporter, rate)
    require_exportable(plan, exporter, rate)
    samples, stops = resampled(plan.trajectory, rate), [stop for stop in found.stops if stop.is_sooner]
    if not stops:
        raise ScenarioError(
            f"{found.plan}: no stop is sooner than the rest of the plan, so that there is none to write"
        )
    rows = {_row(stop, rate): _samples_of(stop, plan, samples, rate) for stop in stops}
    if exporter.name == URSCRIPT.name:
        write_stopping_program(samples, rows, plan.scene, path)
        played, read = read_stopping_program(path, plan.scene)
        paths = [path] * len(stops)
    else:
        paths, read = _written(rows, stops, plan.scene, exporter, path), {}
        for row, stop, file in zip(rows, stops, paths, strict=True):
            read[row] = read_samples(_beginning(exporter, stop), file, plan.scene)
        played = samples
    done = []
    for (row, own), stop, file in zip(read.items(), stops, paths, strict=True):
        _require_joins(samples, row, own, file)
        done.append(WrittenStop(stop, file, _verdict(played, row, own, plan, exporter.interpolation, found.residual)))
    return done


def _samples_of(stop: Stop, plan: Plan, samples: JointSamples, rate: float) -> JointSamples:
    """What a file of a stop holds: the motion of plan and stop together, from the plan's own sample on."""
    motion = QUINTIC_SPLINE.motion(stopped(plan.trajectory, stop))
    own = sampled(motion, stop.t, stop.t + stop.trajectory.end_time, rate, in_motion=True)
    row = _row(stop, rate)
    for column, other in zip(_columns(own), _columns(samples), strict=True):
        column[0] = other[row]
    return own


def _columns(samples: JointSamples) -> list[np.ndarray]:
    """Those that there are."""
    columns = (samples.position, samples.speed, samples.acceleration)
    return [column for column in columns if column is not None]


def _written(
    rows: dict[int, JointSamples], stops: Iterable[Stop], scene: Scene, exporter: Exporter, folder: Path
) -> list[Path]:
    suffix = exporter.suffixes[0]
    names = [f"stop-{round(1e3 * stop.t):06d}{suffix}" for stop in stops]
    with atomic_folder(folder, replaceable=lambda held: all(name.startswith("stop-") for name in held)) as new:
        for name, stop, own in zip(names, stops, rows.values(), strict=True):
            _beginning(exporter, stop).write(own, scene, new / name)
    return [folder / name for name in names]


def _beginning(exporter: Exporter, stop: Stop) -> Exporter:
    return exporter if exporter.beginning is None else exporter.beginning(stop.t)


def _row(stop: Stop, rate: float) -> int:
    """Number of the sample at which a stop begins."""
    row = round(stop.t * rate)
    if abs(stop.t * rate - row) > _ON_GRID:
        raise ScenarioError(
            f"a stop from {stop.t:g} s begins between two samples at {rate:g} Hz; take --every a multiple of "
            f"{1e3 / rate:g} ms"
        )
    return row


def _require_joins(samples: JointSamples, row: int, stop: JointSamples, path: Path) -> None:
    """Refuse a file whose first sample is not the plan's there."""
    for (_, limit), own, other in zip(JOINS.values(), _columns(samples), _columns(stop), strict=False):
        if np.max(np.abs(own[row] - other[0])) > limit:
            raise PlanFolderError(f"{path}: does not begin as the plan moves at {samples.t[row]:g} s; write it again")


def _verdict(
    samples: JointSamples, row: int, stop: JointSamples, plan: Plan, interpolation: Interpolation, residual: float
) -> Certificate:
    """Of the plan until a sample and a stop from there on, as one motion."""
    pairs = zip(_columns(samples), _columns(stop), strict=False)
    t = np.concatenate([samples.t[:row], samples.t[row] + stop.t])
    whole = JointSamples(t, *(np.concatenate([own[:row], other]) for own, other in pairs))
    scene = scene_to_rest(plan.scene, residual)
    return judged_to_rest(interpolation.motion(whole), float(t[-1]), plan.trajectory.rate, scene).certificate
