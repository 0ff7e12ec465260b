"""Changes of the slosh law that could explain the 21 measured runs: the table "What was tried" in docs/slosh-model.md.

    python -m benchmarks.slosh.variants

NOSPILL_DATA names the folder of the measurements, as for `benchmarks.slosh.validate`. One mode on its paraboloid is
integrated for all runs and settings at once, with what the package's law does not have as numbers:

    frequency   factor on the first frequency
    rest        part of the quasi-static height of the faster modes that is added (two modes carry about a half)
    crest       second order of the height, crest * |eta|^2/R: real crests are higher than linear ones
    spring      third order of the restoring force, omega^2 spring |q|^2/R^2 q, as Narimanov-Moiseev systems have it
    gauge       added to every height, m
    axis        where the container's axis is, off its stated place, m, in its own axes
    lag         of the arm behind its command, s
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from scipy.signal import lfilter

from benchmarks.slosh.validate import AFTERWARDS, CUP, REST, data_folder, held
from nospill.simulation.compare import compare
from nospill.simulation.container_motion import body_rows, pose_spline
from nospill.simulation.cup_file import cup_from_table
from nospill.simulation.motion_file import Heights, Motion, checked_motion, read_heights, read_motion

GRAVITY, STEP = 9.80665, 0.004


@dataclass(frozen=True)
class Setting:
    """One setting for all runs."""

    title: str
    damping: float = 0.0051
    frequency: float = 1.0
    rest: float = 0.5
    crest: float = 0.0
    spring: float = 0.0
    gauge: float = 0.0
    axis: tuple[float, float, float] = (0.0, 0.0, 0.0)
    lag: float = 0.0


_FITTED = Setting("axis and five more numbers, fitted to all runs", 0.0587, 1.031, 0.33, 0.123, -0.041, -0.0004)
SETTINGS = (
    Setting("first mode alone", rest=0.0),
    Setting("with half of the rest (two modes)"),
    Setting("damping 0.01", 0.01),
    Setting("damping 0.02", 0.02),
    Setting("frequency + 2 %", frequency=1.02),
    Setting("crest of second order 0.1", 0.01, crest=0.1),
    Setting("hardening spring 0.3", 0.01, spring=0.3),
    Setting("softening spring - 0.3", 0.01, spring=-0.3),
    Setting("gauge 1 mm low", 0.01, gauge=-0.001),
    Setting("arm with a lag of 20 ms", 0.01, lag=0.02),
    Setting("arm with a lag of 40 ms", 0.01, lag=0.04),
    Setting("law fitted: damping, frequency, rest, crest, spring", 0.0055, 1.012, 0.53, 0.095, 0.27),
    replace(_FITTED, axis=(-0.0198, 0.0169, 0.0414)),
)
WITHOUT = {
    "LE": Setting("LE", 0.0451, 0.9896, 0.175, 0.068, axis=(0.034, 0.0081, -0.0016)),
    "RD": Setting("RD", 0.0442, 1.0223, 0.262, 0.0859, axis=(-0.013, 0.0146, 0.007)),
    "TRD": Setting("TRD", 0.0322, 1.0246, 0.549, 0.0905, axis=(-0.0304, 0.013, -0.0251)),
    "Tilt_LE": Setting("Tilt_LE", 0.0348, 1.0366, 0.580, 0.0989, axis=(-0.0229, 0.0188, 0.0)),
    "Tilt_RD": Setting("Tilt_RD", 0.0346, 1.0273, 0.462, 0.0334, axis=(-0.0176, 0.0204, -0.0003)),
    "Tilt_TRD": Setting("Tilt_TRD", 0.0368, 1.0245, 0.450, 0.0702, axis=(-0.021, 0.0173, -0.0128)),
}
"""Damping, frequency, rest, crest and axis fitted to all families but one, by an evolution strategy."""


def _lagged(motion: Motion, lag: float) -> Motion:
    """Every coordinate behind its command by a lag of first order."""
    step = 0.001
    t = np.arange(motion.t[0], motion.t[-1], step)
    poses = np.column_stack([np.interp(t, motion.t, own) for own in np.hstack([motion.position, motion.quaternion]).T])
    keep = np.exp(-step / lag)
    late = np.asarray(lfilter([1.0 - keep], [1.0, -keep], poses, axis=0, zi=keep * poses[:1])[0])[::2]
    turned = late[:, 3:] / np.linalg.norm(late[:, 3:], axis=1)[:, None]
    return checked_motion(t[::2], late[:, :3], turned)


def _cross(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    return np.cross(a, b, axis=0)


class Runs:
    """Motions and measured heights of all runs, on one grid."""

    def __init__(self, lag: float) -> None:
        folder = data_folder() / "slosh-runs"
        self.names = [file.name.removesuffix(".motion.csv") for file in sorted(folder.glob("*.motion.csv"))]
        self.measured = [read_heights(folder / f"{name}.height.csv") for name in self.names]
        rows = []
        for name in self.names:
            motion = read_motion(folder / f"{name}.motion.csv")
            motion = held(motion, AFTERWARDS * (motion.t[-1] - REST))
            motion = _lagged(motion, lag) if lag else motion
            t = np.arange(0.0, motion.t[-1], 0.5 * STEP)
            rows.append(body_rows(pose_spline(motion), t[: len(t) - 1 + len(t) % 2], GRAVITY))
        longest = max(own.shape[1] for own in rows)
        padded = [np.pad(own, ((0, 0), (0, longest - own.shape[1])), mode="edge") for own in rows]
        self.body = np.stack(padded, axis=2)
        self.lengths = [(own.shape[1] + 1) // 2 for own in rows]


def heights(runs: Runs, own: Setting) -> np.ndarray:
    """Crest (steps, runs), m."""
    filling = cup_from_table(CUP, label="cup", slosh_modes=1).filling
    assert filling is not None
    mode = min(filling.modes.oscillators, key=lambda item: item.frequency)
    radius, curvature, gain = 0.049, mode.frequency**2 / GRAVITY, mode.surface_gain
    omega, axis = own.frequency * mode.frequency, np.array(own.axis)[:, None]

    def apparent(index: int, place: np.ndarray, speed: np.ndarray) -> np.ndarray:
        turn, change, force = runs.body[:3, index], runs.body[3:6, index], runs.body[6:, index]
        return force + _cross(change, place) + _cross(turn, _cross(turn, place)) + 2.0 * _cross(turn, speed)

    def rate(index: int, q: np.ndarray, v: np.ndarray) -> np.ndarray:
        square, along = np.sum(q * q, axis=0), np.sum(q * v, axis=0)
        place = axis + np.array([q[0], q[1], mode.height + 0.5 * curvature * square])
        a = apparent(index, place, np.array([v[0], v[1], curvature * along]))
        pull = a[:2] + curvature * (own.frequency**2 * a[2] + curvature * np.sum(v * v, axis=0)) * q
        pull = pull + 2.0 * own.damping * omega * (v + curvature**2 * along * q)
        pull = pull + omega**2 * own.spring * square / radius**2 * q
        return -(pull - curvature**2 * q * np.sum(q * pull, axis=0) / (1.0 + curvature**2 * square))

    q = np.zeros((2, len(runs.names)))
    v, found = np.zeros_like(q), []
    surface = axis + np.array([0.0, 0.0, filling.liquid_height])[:, None] + np.zeros((1, q.shape[1]))
    for index in range(0, runs.body.shape[1], 2):
        a = apparent(index, surface, np.zeros_like(surface))
        level = np.linalg.norm(gain * q - own.rest * (radius - gain / curvature) * a[:2] / a[2], axis=0)
        found.append(level + own.crest * level**2 / radius + own.gauge)
        if index + 2 < runs.body.shape[1]:
            k1, k1v = v, rate(index, q, v)
            k2, k2v = v + 0.5 * STEP * k1v, rate(index + 1, q + 0.5 * STEP * k1, v + 0.5 * STEP * k1v)
            k3, k3v = v + 0.5 * STEP * k2v, rate(index + 1, q + 0.5 * STEP * k2, v + 0.5 * STEP * k2v)
            k4, k4v = v + STEP * k3v, rate(index + 2, q + STEP * k3, v + STEP * k3v)
            q, v = q + STEP / 6 * (k1 + 2 * k2 + 2 * k3 + k4), v + STEP / 6 * (k1v + 2 * k2v + 2 * k3v + k4v)
    return np.array(found)


def compared(runs: Runs, own: Setting) -> np.ndarray:
    """Correlation, rms error in mm and relative peak error of every run, (runs, 3)."""
    predicted, rows = heights(runs, own), []
    for column, (length, measured) in enumerate(zip(runs.lengths, runs.measured, strict=True)):
        found = compare(Heights(STEP * np.arange(length), predicted[:length, column]), measured)
        rows.append((found.correlation, 1e3 * found.rmse, found.relative_peak_error))
    return np.array(rows)


def _line(title: str, found: np.ndarray, usual: np.ndarray, families: list[str]) -> str:
    peaks = [f"{100 * np.mean(found[np.array(families) == name, 2]):+.0f}" for name in dict.fromkeys(families)]
    better = np.count_nonzero(np.abs(found[:, 2]) < np.abs(usual[:, 2])), np.count_nonzero(found[:, 1] < usual[:, 1])
    medians = np.median(np.column_stack([100 * np.abs(found[:, 2]), found[:, 0], found[:, 1]]), axis=0)
    figures = f"{medians[0]:.1f} % | {medians[1]:.3f} | {medians[2]:.2f} mm"
    return f"| {title} | {figures} | {', '.join(peaks)} | {better[0]}, {better[1]} |"


def main() -> None:
    """Print the table."""
    known = {0.0: Runs(0.0)}
    families = [name.partition("_2D")[0] for name in known[0.0].names]
    usual, names = compared(known[0.0], SETTINGS[1]), ", ".join(dict.fromkeys(families))
    print(f"| setting for all runs | peak | r | rmse | mean peak error % of {names} | better |")
    print("|---|---|---|---|---|---|")
    for own in SETTINGS:
        runs = known.get(own.lag) or known.setdefault(own.lag, Runs(own.lag))
        print(_line(own.title, compared(runs, own), usual, families), flush=True)
    left_out = np.zeros_like(usual)
    for name, own in WITHOUT.items():
        mask = np.array(families) == name
        left_out[mask] = compared(known[0.0], own)[mask]
    print(_line("axis and four more numbers, each family predicted from the others", left_out, usual, families))


if __name__ == "__main__":
    main()
