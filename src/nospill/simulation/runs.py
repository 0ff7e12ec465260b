"""Several runs of one container at once: predicted with the band that its tolerance leaves, against measured."""

from __future__ import annotations

import os
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from nospill.errors import ScenarioError
from nospill.scene.cargo import Cargo
from nospill.scene.perturbation import Perturbation, perturbed
from nospill.simulation.compare import Comparison, compare
from nospill.simulation.cup_file import read_cup
from nospill.simulation.motion_file import Heights, Motion, checked_motion, read_heights, read_motion
from nospill.simulation.simulate import simulate_slosh

AFTERWARDS = 0.3
"""Durations of a motion that are compared after its end."""
_MOTION, _HEIGHT = ".motion.csv", ".height.csv"
_STILL = 1e-5
"""m, or of a quaternion's components; a pose that differs by less from the first or the last stands."""


@dataclass(frozen=True, slots=True, eq=False)
class RunComparison:
    """One run.

    Attributes:
        name: of its files, without their endings.
        comparison: with the numbers as stated.
        low: (m,) least height over the corners of the tolerance, at `comparison.t`, m.
        high: likewise, the greatest.
    """

    name: str
    comparison: Comparison
    low: np.ndarray
    high: np.ndarray

    @property
    def within(self) -> float:
        """Part of the measured samples that lie within the band."""
        own = self.comparison
        return float(np.mean((own.measured >= self.low) & (own.measured <= self.high)))


def compare_runs(
    folder: str | os.PathLike[str],
    cup: str | os.PathLike[str],
    *,
    modes: int | None = None,
    height: str = "one-mode",
    azimuth: float | None = None,
    model: str = "surface",
) -> tuple[RunComparison, ...]:
    """Compare every run of a folder: NAME.motion.csv of a container with NAME.height.csv of its liquid.

    After its end a motion is held for another 0.3 durations. Nothing is fitted but the clocks.

    Args:
        folder: with the runs.
        cup: TOML file with the keys of a cargo entry; of its `tolerance`, fill and damping make the band.
        modes: liquid modes in each direction, by default those of the model.
        height: "one-mode" or "corrected", as for `simulate_slosh`.
        azimuth: rad, from the container's x towards its y, where the height was measured, with its sign; that of the
            crest when left out.
        model: "surface" or "contact-line", as for `simulate_slosh`.

    Raises:
        ScenarioError: no runs, a height without its motion or the other way round, or a file that is refused.
        ModelError: the liquid does not stay in its container.
    """
    place = Path(folder)
    names = sorted(path.name.removesuffix(_MOTION) for path in place.glob(f"*{_MOTION}"))
    if not names:
        raise ScenarioError(f"{place}: no runs: NAME{_MOTION} and NAME{_HEIGHT} are needed")
    missing = [name for name in names if not (place / f"{name}{_HEIGHT}").is_file()]
    if missing:
        raise ScenarioError(f"{place}: {missing[0]}{_HEIGHT} is missing beside {missing[0]}{_MOTION}")
    cargo = read_cup(cup)
    comparisons = []
    for name in names:
        motion = _hold(read_motion(place / f"{name}{_MOTION}"))

        def predicted(item: Cargo, motion: Motion = motion) -> Heights:
            return simulate_slosh(
                item,
                motion.t,
                motion.position,
                motion.quaternion,
                modes=modes,
                height=height,
                azimuth=azimuth,
                model=model,
            ).heights

        measured = read_heights(place / f"{name}{_HEIGHT}")
        comparison = compare(predicted(cargo), measured, signed=azimuth is not None)
        corners = [comparison.predicted]
        for corner in _corners(cargo):
            other = predicted(corner)
            at_times = np.interp(comparison.t, other.t, other.height)
            corners.append(at_times if azimuth is not None else np.abs(at_times))
        comparisons.append(RunComparison(name, comparison, np.min(corners, axis=0), np.max(corners, axis=0)))
    return tuple(comparisons)


def _corners(cargo: Cargo) -> Iterator[Cargo]:
    """The container at the ends of the ranges of its fill and its damping."""
    tolerance = cargo.tolerance
    if tolerance is None:
        return
    rises = sorted({-tolerance.liquid_height, tolerance.liquid_height})
    for rise in rises:
        for factor in sorted(set(tolerance.damping)):
            if rise or factor != 1.0:
                yield perturbed(cargo, Perturbation(liquid_height=rise, damping=factor), fidelity="full")


def _hold(motion: Motion) -> Motion:
    """The motion with its last pose kept for a part of its duration."""
    poses = np.hstack([motion.position, motion.quaternion])
    left, arrived = (np.max(np.abs(poses - poses[end]), axis=1) > _STILL for end in (0, -1))
    if not left.any():
        return motion
    duration = motion.t[np.flatnonzero(arrived)[-1]] - motion.t[np.flatnonzero(left)[0]]
    step = float(np.median(np.diff(motion.t)))
    count = int(AFTERWARDS * duration / step)
    return checked_motion(
        np.concatenate([motion.t, motion.t[-1] + step * np.arange(1, count + 1)]),
        np.concatenate([motion.position, np.repeat(motion.position[-1:], count, axis=0)]),
        np.concatenate([motion.quaternion, np.repeat(motion.quaternion[-1:], count, axis=0)]),
    )
