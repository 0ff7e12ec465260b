"""The measured runs with the certificate's surface, of first and of second order, as what the gauge reads.

    python -m benchmarks.water.gauge

The first order is `simulate_slosh` with twenty modes, the mass of the first on its paraboloid; the second is what the
judge adds to it (`certification.second_order`). For both the medians over the runs of |peak error|, correlation and rms
error, as the surface itself and read at the contact line, damping as in `benchmarks.slosh.contact_line`, and how many
runs have the smaller rms error of both.
"""

from __future__ import annotations

import numpy as np

from benchmarks.slosh.contact_line import CHOSEN
from benchmarks.slosh.validate import AFTERWARDS, CUP, REST, data_folder, held
from nospill.certification.second_order import waves_along
from nospill.scene.sloshing.modes import STANDARD_GRAVITY
from nospill.simulation.compare import compare
from nospill.simulation.container_motion import body_rows, pose_spline
from nospill.simulation.cup_file import cup_from_table
from nospill.simulation.motion_file import Heights, read_heights, read_motion
from nospill.simulation.readings import reading_of
from nospill.simulation.simulate import simulate_slosh

MODES = 20


def surfaces(name: str) -> tuple[np.ndarray, dict[str, np.ndarray]]:
    """Times (m,), s, of a run and the heights (m,), m, of both surfaces."""
    motion = read_motion(data_folder() / "slosh-runs" / f"{name}.motion.csv")
    motion = held(motion, AFTERWARDS * (motion.t[-1] - REST))
    cup = cup_from_table({**CUP, "damping": CHOSEN[0]}, slosh_modes=MODES)
    own = simulate_slosh(cup, motion.t, motion.position, motion.quaternion, modes=MODES)
    step = float(np.median(np.diff(motion.t)))
    even = motion.t[0] + step * np.arange(len(motion.t))

    def at_even(values: np.ndarray) -> np.ndarray:
        return np.stack([np.interp(even, motion.t, column) for column in values.T], axis=1)

    body = body_rows(pose_spline(motion), np.clip(even, motion.t[0], motion.t[-1]), STANDARD_GRAVITY)
    second = waves_along(cup, body, at_even(own.displacement), at_even(own.velocity), step).crests
    return even, {"first": np.interp(even, motion.t, own.height), "second": second}


def main() -> None:
    """Print the table."""
    folder = data_folder() / "slosh-runs"
    names = [file.name.removesuffix(".motion.csv") for file in sorted(folder.glob("*.motion.csv"))]
    measured = [read_heights(folder / f"{name}.height.csv") for name in names]
    found = [surfaces(name) for name in names]
    liquid = cup_from_table(CUP, slosh_modes=1).filling
    assert liquid is not None
    print(f"{len(names)} runs\n| read as | order | peak error | |peak error| | r | rms mm |\n|---|---|---|---|---|---|")
    for model in ("surface", "contact-line"):
        reading, rms = reading_of(model), {}
        for order in ("first", "second"):
            shown = [Heights(t, reading.of(heights[order], liquid.liquid)) for t, heights in found]
            runs = [compare(own, theirs) for own, theirs in zip(shown, measured, strict=True)]
            off = 1e2 * np.array([run.relative_peak_error for run in runs])
            rms[order] = 1e3 * np.array([run.rmse for run in runs])
            correlation = np.median([run.correlation for run in runs])
            figures = f"{np.median(off):+.1f} % | {np.median(np.abs(off)):.1f} % | {correlation:.3f}"
            print(f"| {model} | {order} | {figures} | {np.median(rms[order]):.2f} |")
        print(f"smaller rms error to the second order: {np.sum(rms['second'] < rms['first'])} runs")


if __name__ == "__main__":
    main()
