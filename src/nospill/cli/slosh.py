"""simulate, compare: the liquid in one container, predicted and measured."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from nospill.cli.tables import print_table


def simulate(
    cup: Annotated[Path, typer.Argument(metavar="CUP.toml", help="A container: the keys of a cargo entry.")],
    motion: Annotated[
        Path, typer.Argument(metavar="MOTION.csv", help="Its motion: t_s, x_m, y_m, z_m, qx, qy, qz, qw.")
    ],
    output: Annotated[
        Path | None,
        typer.Option("-o", "--output", metavar="OUT.csv", help="Write t_s, height_mm here.", show_default=False),
    ] = None,
    modes: Annotated[
        int | None,
        typer.Option(
            "--modes",
            metavar="N",
            help="Liquid modes in each direction; by default 2, of the contact line 20.",
            show_default=False,
        ),
    ] = None,
    height: Annotated[
        str,
        typer.Option(
            "--height",
            metavar="one-mode|corrected",
            help="The carried modes alone, or with the quasi-static part of all the others.",
        ),
    ] = "one-mode",
    model: Annotated[
        str,
        typer.Option(
            "--model",
            metavar="surface|contact-line",
            help="What OUT.csv holds: the surface, or the contact line at the wall, which stays behind it.",
        ),
    ] = "surface",
) -> int:
    """Predict the height of the liquid in one container that is moved in a given way."""
    from nospill.simulation.motion_file import read_motion, write_heights
    from nospill.simulation.simulate import simulate_slosh

    given = read_motion(motion)
    simulation = simulate_slosh(cup, given.t, given.position, given.quaternion, modes=modes, height=height, model=model)
    if output is not None:
        write_heights(output, simulation.heights)
    print(f"peak height: {1e3 * simulation.peak:.2f} mm above rest at t = {simulation.peak_time:.3f} s")
    if model != "surface":
        print(f"peak of the contact line: {1e3 * float(simulation.reading.max()):.2f} mm above rest")
    print(
        f"rim: {1e3 * simulation.freeboard:.2f} mm above rest"
        + (": the liquid spills" if simulation.peak > simulation.freeboard else "")
    )
    if output is not None:
        print(f"written to {output}")
    return 0


def compare(
    predicted: Annotated[
        str,
        typer.Argument(
            metavar="PREDICTED", help="A CSV (t_s, height_mm), a plan folder and a cup as DIR:CUP, or a folder of runs."
        ),
    ],
    measured: Annotated[
        Path | None,
        typer.Argument(
            metavar="MEASURED.csv", help="The measured height: t_s, height_mm; none for runs.", show_default=False
        ),
    ] = None,
    cup: Annotated[
        Path | None,
        typer.Option(
            "--cup", metavar="CUP.toml", help="Of a folder of runs: the keys of a cargo entry.", show_default=False
        ),
    ] = None,
    modes: Annotated[
        int | None,
        typer.Option("--modes", metavar="N", help="Of runs: liquid modes in each direction.", show_default=False),
    ] = None,
    height: Annotated[
        str, typer.Option("--height", metavar="one-mode|corrected", help="Of runs: as for simulate.")
    ] = "one-mode",
    model: Annotated[
        str, typer.Option("--model", metavar="surface|contact-line", help="Of runs: as for simulate.")
    ] = "surface",
    azimuth: Annotated[
        str | None,
        typer.Option(
            "--azimuth",
            metavar="ANGLE",
            help="Of runs: measured at this place of the wall, with signs, not at the crest.",
            show_default=False,
        ),
    ] = None,
    figure: Annotated[
        Path | None,
        typer.Option("-o", "--output", metavar="FIG", help="Draw them (.png, .pdf or .svg).", show_default=False),
    ] = None,
) -> int:
    """Compare predicted liquid heights with measured ones; the clocks are aligned by best correlation.

    A folder of runs holds NAME.motion.csv and NAME.height.csv of one container; the band is that of its tolerance.
    """
    from nospill.errors import ScenarioError

    if figure is not None:
        from nospill.plots.comparison import require_figure_name

        require_figure_name(figure)
    if (measured is None) != (cup is not None):
        raise ScenarioError("give MEASURED.csv beside one prediction, or --cup CUP.toml beside a folder of runs")
    if measured is not None:
        return _compare_one(predicted, measured, figure)
    assert cup is not None  # as was just checked
    return _compare_runs(Path(predicted), cup, modes, height, model, azimuth, figure)


def _compare_one(predicted: str, measured: Path, figure: Path | None) -> int:
    from nospill.simulation.compare import compare as compare_heights
    from nospill.simulation.compare import predicted_heights
    from nospill.simulation.motion_file import read_heights

    comparison = compare_heights(predicted_heights(predicted), read_heights(measured))
    print_table(
        ("figure", "value", "unit"),
        [
            ("predicted peak", 1e3 * comparison.predicted_peak, "mm"),
            ("measured peak", 1e3 * comparison.measured_peak, "mm"),
            ("peak error", 1e3 * comparison.peak_error, "mm"),
            ("peak error", 1e2 * comparison.relative_peak_error, "%"),
            ("root mean square error", 1e3 * comparison.rmse, "mm"),
            ("correlation", comparison.correlation, ""),
            ("integral error", 1e2 * comparison.integral_error, "%"),
            ("clock shift", comparison.shift, "s"),
        ],
    )
    if figure is not None:
        from nospill.plots.comparison import save_comparison

        save_comparison(comparison, figure)
        print(f"drawn to {figure}")
    return 0


def _compare_runs(
    folder: Path, cup: Path, modes: int | None, height: str, model: str, azimuth: str | None, figure: Path | None
) -> int:
    import numpy as np

    from nospill.core.units import quantity
    from nospill.simulation.runs import compare_runs

    place = None if azimuth is None else quantity(azimuth, "angle")
    runs = compare_runs(folder, cup, modes=modes, height=height, azimuth=place, model=model)
    banded = any(np.any(run.high > run.low) for run in runs)
    rows = []
    for run in runs:
        comparison = run.comparison
        figures = (
            comparison.correlation,
            1e3 * comparison.rmse,
            1e2 * comparison.relative_peak_error,
            1e2 * comparison.integral_error,
        )
        band = (f"{100 * run.within:.0f} %",) if banded else ()
        rows.append((run.name, f"{1e3 * comparison.measured_peak:.1f}", *(f"{value:.3g}" for value in figures), *band))
    peaks = np.median([abs(run.comparison.relative_peak_error) for run in runs])
    columns = ("run", "measured peak mm", "correlation", "rms error mm", "peak error %", "integral error %")
    print_table((*columns, *(("within band",) if banded else ())), rows, right=(*columns[1:], "within band"))
    print()
    medians = [np.median([getattr(run.comparison, name) for run in runs]) for name in ("correlation", "rmse")]
    print(
        f"medians of {len(runs)} runs: |peak error| {1e2 * peaks:.1f} %, correlation {medians[0]:.3f}, "
        f"rms error {1e3 * medians[1]:.2f} mm"
    )
    if figure is not None:
        from nospill.plots.runs import save_runs

        save_runs(runs, figure)
        print(f"drawn to {figure}")
    return 0
