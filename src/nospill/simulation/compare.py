"""A predicted height compared with a measured one: their clocks aligned, their differences in figures."""

from __future__ import annotations

import os
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from nospill.core.units import listed
from nospill.errors import ScenarioError
from nospill.plans.loading import load_plan
from nospill.simulation.motion_file import Heights, read_heights

ALIGNMENT_STEP = 0.002
"""s; both records are resampled to this for the search, which then goes below it by a parabola."""

_LEAST_OVERLAP = 0.8
"""Least common part, as a fraction of the shorter record: two short flat ends would correlate well too."""
_MOST_SAMPLES = 5_000_000


@dataclass(frozen=True, slots=True)
class Comparison:
    """A measured height against its prediction, over their common time.

    Attributes:
        t: (m,) s, the measured samples on the predicted clock.
        predicted: (m,) values there, absolute unless signs were compared, m.
        measured: (m,) likewise, m.
        shift: s, added to the predicted clock gives the measured one.
        correlation: Pearson's.
        rmse: root mean square of predicted - measured, m.
        predicted_peak: m.
        measured_peak: likewise.
        integral_error: integral of predicted - measured over the integral of measured.
    """

    t: np.ndarray
    predicted: np.ndarray
    measured: np.ndarray
    shift: float
    correlation: float
    rmse: float
    predicted_peak: float
    measured_peak: float
    integral_error: float

    @property
    def peak_error(self) -> float:
        """Predicted less measured peak, m."""
        return self.predicted_peak - self.measured_peak

    @property
    def relative_peak_error(self) -> float:
        """`peak_error` over the measured peak."""
        return self.peak_error / self.measured_peak


def compare(predicted: Heights, measured: Heights, *, signed: bool = False) -> Comparison:
    """Align the clock of a measured height with its prediction's and compare the absolute heights, or those with signs.

    The prediction is a crest, which has no sign; a measured height may fall below rest where the crest is not in sight.
    The clocks are put where the normalised cross-correlation of the two absolute heights is greatest among all shifts
    that leave at least 80 % of the shorter record in common.

    Args:
        predicted: any rate.
        measured: any rate; its clock may start anywhere.
        signed: whether both are heights at one place of the wall, above and below rest.

    Raises:
        ScenarioError: one of the two never moves, or is too long to be searched.
    """
    size = np.asarray if signed else np.abs
    shift = _best_shift(predicted, measured, signed=signed)
    t = measured.t - shift
    common = (t >= predicted.t[0] - 1e-9) & (t <= predicted.t[-1] + 1e-9)
    if np.count_nonzero(common) < 2:
        raise ScenarioError("measured: fewer than two samples lie within the prediction; give a longer or finer record")
    t = t[common]
    ours = np.interp(t, predicted.t, size(predicted.height))
    theirs = np.array(size(measured.height[common]))
    # The peak is taken where the prediction was computed, not only where it was measured.
    window = (predicted.t >= t[0] - 1e-9) & (predicted.t <= t[-1] + 1e-9)
    area = float(np.trapezoid(np.abs(theirs), t))
    for array in (t, ours, theirs):
        array.flags.writeable = False
    return Comparison(
        t=t,
        predicted=ours,
        measured=theirs,
        shift=shift,
        correlation=_correlation(ours, theirs),
        rmse=float(np.sqrt(np.mean((ours - theirs) ** 2))),
        predicted_peak=float(np.max(size(predicted.height[window]), initial=float(np.max(ours)))),
        measured_peak=float(np.max(theirs)),
        integral_error=(float(np.trapezoid(np.abs(ours), t)) - area) / area,
    )


def predicted_heights(source: str | os.PathLike[str]) -> Heights:
    """The predicted side of a comparison by its name.

    Args:
        source: a CSV of heights, or a plan folder and a cup's name as FOLDER:CUP. A file of the very name wins. From a
            plan the height that was planned is taken, over the exported trajectory.

    Raises:
        ScenarioError: no such file or no such cup. PlanFolderError: the folder is no plan.
    """
    name = os.fsdecode(source)
    folder, colon, cup = name.rpartition(":")
    if os.path.isfile(name) or not colon or not os.path.isdir(folder):
        if os.path.isdir(name):
            raise ScenarioError(f"{name}: is a folder; for a plan add the cup's name, as in {name}:c1")
        return read_heights(source)
    trajectory = load_plan(Path(folder)).trajectory
    if cup not in trajectory.slosh:
        known = tuple(trajectory.slosh)
        choose = f"choose {listed(known)}" if known else "nothing in this plan holds a liquid"
        raise ScenarioError(f'{folder}: no cup "{cup}" with a liquid; {choose}')
    return Heights(trajectory.t, trajectory.slosh[cup].height)


def _best_shift(predicted: Heights, measured: Heights, *, signed: bool) -> float:
    ours, theirs = _resample(predicted, "predicted", signed=signed), _resample(measured, "measured", signed=signed)
    lags, value = _normalised_correlation(ours, theirs)
    best = int(np.argmax(value))
    lag = float(lags[best])
    if 0 < best < len(value) - 1:
        before, at, after = value[best - 1 : best + 2]
        bend = before - 2 * at + after
        if bend < 0.0:
            lag += 0.5 * (before - after) / bend
    return measured.t[0] - predicted.t[0] + lag * ALIGNMENT_STEP


def _resample(heights: Heights, label: str, *, signed: bool) -> np.ndarray:
    count = int((heights.t[-1] - heights.t[0]) / ALIGNMENT_STEP) + 1
    if count > _MOST_SAMPLES:
        raise ScenarioError(f"{label}: {heights.t[-1] - heights.t[0]:.4g} s is too long to be aligned; cut it")
    height = np.interp(heights.t[0] + ALIGNMENT_STEP * np.arange(count), heights.t, heights.height)
    height = height if signed else np.abs(height)
    if np.ptp(height) <= 1e-9:
        raise ScenarioError(f"{label}: the height never changes; there is nothing to align the clocks by")
    return height


def _normalised_correlation(ours: np.ndarray, theirs: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Lags (theirs index less ours) and Pearson's correlation of the parts in common at each, both (k,)."""
    from scipy.signal import correlate

    lags = np.arange(-(len(ours) - 1), len(theirs))
    # Removing the means first keeps the differences of large sums below exact.
    ours, theirs = ours - np.mean(ours), theirs - np.mean(theirs)
    start, stop = np.maximum(0, -lags), np.minimum(len(ours), len(theirs) - lags)
    count = stop - start
    kept = count >= _LEAST_OVERLAP * min(len(ours), len(theirs))
    product = correlate(theirs, ours, mode="full", method="fft")[kept]
    lags, start, stop, count = lags[kept], start[kept], stop[kept], count[kept]
    sum_ours, square_ours = _sums(ours, start, stop)
    sum_theirs, square_theirs = _sums(theirs, start + lags, stop + lags)
    spread = (square_ours - sum_ours**2 / count) * (square_theirs - sum_theirs**2 / count)
    least = 1e-9 * float(np.sum(ours**2) * np.sum(theirs**2))  # a flat part correlates with nothing
    value = np.full(len(lags), -1.0)
    np.divide(
        product - sum_ours * sum_theirs / count, np.sqrt(np.maximum(spread, least)), out=value, where=spread > least
    )
    return lags, value


def _sums(values: np.ndarray, start: np.ndarray, stop: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Sum and sum of squares of values[start:stop] for arrays of bounds."""
    first = np.concatenate([[0.0], np.cumsum(values)])
    second = np.concatenate([[0.0], np.cumsum(values**2)])
    return first[stop] - first[start], second[stop] - second[start]


def _correlation(ours: np.ndarray, theirs: np.ndarray) -> float:
    a, b = ours - np.mean(ours), theirs - np.mean(theirs)
    scale = float(np.sqrt(np.sum(a * a) * np.sum(b * b)))
    return float(np.sum(a * b)) / scale if scale > 0.0 else 0.0
