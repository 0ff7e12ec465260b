"""The measured runs with the surface of second order and of the whole flow as what the gauge reads.

    python -m benchmarks.water.measured

Medians over the runs of |peak error|, correlation and rms error, for the surface itself and read at the contact line
(`nospill.simulation.readings`), damping as in `benchmarks.slosh.contact_line`.
"""

from __future__ import annotations

import numpy as np

from benchmarks.slosh.contact_line import CHOSEN
from benchmarks.slosh.validate import AFTERWARDS, CUP, REST, data_folder, held
from nospill.potential_flow import Crests, crests_along
from nospill.scene.sloshing.modes import STANDARD_GRAVITY
from nospill.simulation.compare import compare
from nospill.simulation.container_motion import body_rows, pose_spline
from nospill.simulation.cup_file import cup_from_table
from nospill.simulation.motion_file import Heights, read_heights, read_motion
from nospill.simulation.readings import reading_of

ORDERS = ("linear", "second", "full")


def followed(name: str) -> Crests:
    """The liquid of a run."""
    motion = read_motion(data_folder() / "slosh-runs" / f"{name}.motion.csv")
    motion = held(motion, AFTERWARDS * (motion.t[-1] - REST))
    spline = pose_spline(motion)
    cup = cup_from_table({**CUP, "damping": CHOSEN[0]}, slosh_modes=20)

    def rows(t: np.ndarray) -> np.ndarray:
        return body_rows(spline, np.clip(t, motion.t[0], motion.t[-1]), STANDARD_GRAVITY)

    return crests_along(cup, rows, float(motion.t[0]), float(motion.t[-1]), after=0.0)


def main() -> None:
    """Print a line for each order and reading, and how many flows are trusted or get to the end."""
    names = [
        file.name.removesuffix(".motion.csv") for file in sorted((data_folder() / "slosh-runs").glob("*.motion.csv"))
    ]
    found = {name: followed(name) for name in names}
    measured = {name: read_heights(data_folder() / "slosh-runs" / f"{name}.height.csv") for name in names}
    whole = [name for name in names if found[name].breaks_at is None]
    print(f"{len(names)} runs; the whole flow goes through {len(whole)} and is trusted in", end=" ")
    print(sum(found[name].doubt is None for name in names))
    print("| runs | surface | reading | peak error | |peak error| | r | rms mm |\n|---|---|---|---|---|---|---|")
    liquid = cup_from_table(CUP, slosh_modes=1).filling
    assert liquid is not None
    for of, chosen in (("all", names), ("those", whole)):
        for order in ORDERS if of == "those" else ORDERS[:2]:
            for model in ("surface", "contact-line"):
                reading = reading_of(model)
                runs = []
                for name in chosen:
                    heights = getattr(found[name], order)
                    shown = Heights(found[name].t[: len(heights)], reading.of(heights, liquid.liquid))
                    runs.append(compare(shown, measured[name]))
                off = 1e2 * np.array([run.relative_peak_error for run in runs])
                correlation = np.median([run.correlation for run in runs])
                rms = 1e3 * np.median([run.rmse for run in runs])
                figures = f"{np.median(off):+.1f} % | {np.median(np.abs(off)):.1f} % | {correlation:.3f} | {rms:.2f}"
                print(f"| {of}: {len(chosen)} | {order} | {model} | {figures} |")


if __name__ == "__main__":
    main()
