"""What a gauge reads of a surface with all its modes: the tables of the contact line in docs/slosh-model.md.

    python -m benchmarks.slosh.contact_line             print the tables
    python -m benchmarks.slosh.contact_line --figure    draw docs/images/measured-runs.png, a run of each family

NOSPILL_DATA names the folder of the measurements, as for `benchmarks.slosh.validate`. The runs are simulated once for
every damping ratio; readings follow from the heights.
"""

from __future__ import annotations

import argparse
import tempfile
from itertools import pairwise
from pathlib import Path

import numpy as np

from benchmarks.slosh.validate import AFTERWARDS, CUP, REPOSITORY, REST, data_folder, held
from nospill.plots.runs import save_runs
from nospill.simulation.compare import Comparison, compare
from nospill.simulation.motion_file import Heights, read_heights, read_motion
from nospill.simulation.runs import compare_runs
from nospill.simulation.simulate import simulate_slosh

DAMPING = (0.0056, 0.01, 0.0125, 0.015, 0.02, 0.025, 0.03)
"""Ratios of the first mode; free decays of the container have 0.0056."""
LAGS = tuple(2.5e-4 * count for count in range(19))
"""m; by how much a reading stays behind the surface at most."""
CHOSEN = 0.015, 2.5e-3
EDGES = (0.0, 1.0, 2.0, 4.0, 6.0, 8.0, 10.0, 15.0, 20.0, 25.0, 30.0, 40.0, 60.0)
"""mm; classes of predicted height."""

DRAWN = (
    "LE_2D_0m_5s_900deg",
    "RD_2D_0.3m_6.5s_720deg",
    "TRD_2D_0.3m_2.4s_270deg",
    "Tilt_LE_2D_0m_6.5s_30deg",
    "Tilt_RD_2D_0.3m_7.5s_20deg",
    "Tilt_TRD_2D_0.3m_3s_30deg",
)
"""A run of each family."""
PICTURE = REPOSITORY / "docs" / "images" / "measured-runs.png"

Key = tuple[float, float]


def _read(height: np.ndarray, lag: float) -> np.ndarray:
    return height - np.minimum(0.5 * height, lag)


def simulated(folder_name: str = "slosh-runs") -> tuple[dict[float, list[Heights]], list[Heights], list[str]]:
    """Heights of the surface by damping ratio, measured heights, names of the families; run by run."""
    folder = data_folder() / folder_name
    names = [file.name.removesuffix(".motion.csv") for file in sorted(folder.glob("*.motion.csv"))]
    found: dict[float, list[Heights]] = {ratio: [] for ratio in DAMPING}
    for name in names:
        motion = read_motion(folder / f"{name}.motion.csv")
        motion = held(motion, AFTERWARDS * (motion.t[-1] - REST))
        for ratio in DAMPING:
            cup = {**CUP, "damping": ratio}
            found[ratio].append(simulate_slosh(cup, motion.t, motion.position, motion.quaternion, modes=20).heights)
    measured = [read_heights(folder / f"{name}.height.csv") for name in names]
    return found, measured, [name.partition("_2D")[0] for name in names]


def _compared(surface: list[Heights], measured: list[Heights], lag: float) -> list[Comparison]:
    return [
        compare(Heights(own.t, _read(own.height, lag)), theirs) for own, theirs in zip(surface, measured, strict=True)
    ]


def _figures(runs: list[Comparison]) -> np.ndarray:
    """(runs, 3): |peak error| in %, correlation, rms error in mm."""
    return np.array([(1e2 * abs(run.relative_peak_error), run.correlation, 1e3 * run.rmse) for run in runs])


def _medians(figures: np.ndarray) -> str:
    peak, correlation, rmse = np.median(figures, axis=0)
    return f"{peak:.1f} % | {correlation:.3f} | {rmse:.2f} mm"


def _left_out(figures: dict[Key, np.ndarray], families: np.ndarray) -> tuple[np.ndarray, dict[str, Key]]:
    """Figures of each family with the setting that is best for the others, by the sum of the three means."""
    found, chosen = np.zeros_like(next(iter(figures.values()))), {}
    for name in dict.fromkeys(families):
        own = families == name

        def cost(key: Key, own: np.ndarray = own) -> float:
            peak, correlation, rmse = figures[key][~own].mean(axis=0)
            return float(peak / 5.0 + rmse / 2.5 + (1.0 - correlation) / 0.05)

        best = min(figures, key=cost)
        chosen[str(name)] = best
        found[own] = figures[best][own]
    return found, chosen


def draw() -> None:
    """The runs of the figure, predicted with the band of 2 mm of fill and half to twice the damping, and measured."""
    cup = [f'{key} = "{value}"' for key, value in CUP.items()] + [f"damping = {CHOSEN[0]}"]
    tolerance = ["[tolerance]", 'liquid_height = "2 mm"', "damping = [0.5, 2.0]"]
    with tempfile.TemporaryDirectory() as place:
        folder = Path(place)
        (folder / "cup.toml").write_text("\n".join(cup + tolerance), encoding="utf-8")
        for name in DRAWN:
            for ending in (".motion.csv", ".height.csv"):
                (folder / f"{name}{ending}").symlink_to((data_folder() / "slosh-runs" / f"{name}{ending}").resolve())
        save_runs(compare_runs(folder, folder / "cup.toml", model="contact-line"), PICTURE)


def main() -> None:
    """Print the tables, or draw the figure."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--figure", action="store_true")
    if parser.parse_args().figure:
        draw()
        return
    surfaces, measured, names = simulated()
    families = np.array(names)
    plain = _compared(surfaces[0.01], measured, 0.0)
    predicted = 1e3 * np.concatenate([run.predicted for run in plain])
    off = 1e3 * np.concatenate([run.measured for run in plain]) - predicted
    print("| predicted height mm | samples | measured less predicted, median mm |\n|---|---|---|")
    for low, high in pairwise(EDGES):
        own = (predicted >= low) & (predicted < high)
        print(f"| {low:.0f} to {high:.0f} | {np.count_nonzero(own)} | {np.median(off[own]):+.1f} |")

    figures = {(ratio, lag): _figures(_compared(surfaces[ratio], measured, lag)) for ratio in DAMPING for lag in LAGS}
    print("\n| damping | lag mm | peak | r | rmse |\n|---|---|---|---|---|")
    for ratio in (0.0056, 0.01, 0.015, 0.02):
        for lag in (0.0, 1.5e-3, 2.5e-3, 3.5e-3):
            print(f"| {ratio} | {1e3 * lag:.1f} | {_medians(figures[ratio, lag])} |")
    others, chosen = _left_out(figures, families)
    print(f"\neach family predicted from the others: {_medians(others)}")
    for name, (ratio, lag) in chosen.items():
        print(f"  {name}: damping {ratio}, lag {1e3 * lag:.2f} mm")
    own, before = figures[CHOSEN], figures[0.0056, 0.0]
    signed = np.array([run.relative_peak_error for run in _compared(surfaces[CHOSEN[0]], measured, CHOSEN[1])])
    better = np.count_nonzero(own[:, 0] < before[:, 0]), np.count_nonzero(own[:, 2] < before[:, 2])
    peaks = [f"{name} {1e2 * signed[families == name].mean():+.0f}" for name in dict.fromkeys(names)]
    print(f"\nchosen {CHOSEN}: {_medians(own)}; better than the surface in peak, rmse: {better}; {', '.join(peaks)}")


if __name__ == "__main__":
    main()
