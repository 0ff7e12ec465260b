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
    modes: Annotated[int, typer.Option("--modes", metavar="N", help="Liquid modes in each direction.")] = 2,
    height: Annotated[
        str,
        typer.Option(
            "--height",
            metavar="one-mode|corrected",
            help="The carried modes alone, or with the quasi-static part of all the others.",
        ),
    ] = "one-mode",
) -> int:
    """Predict the height of the liquid in one container that is moved in a given way."""
    from nospill.simulation.motion_file import read_motion, write_heights
    from nospill.simulation.simulate import simulate_slosh

    given = read_motion(motion)
    found = simulate_slosh(cup, given.t, given.position, given.quaternion, modes=modes, height=height)
    if output is not None:
        write_heights(output, found.heights)
    print(f"peak height: {1e3 * found.peak:.2f} mm above rest at t = {found.peak_time:.3f} s")
    print(f"rim: {1e3 * found.room:.2f} mm above rest" + (": the liquid spills" if found.peak > found.room else ""))
    if output is not None:
        print(f"written to {output}")
    return 0


def compare(
    predicted: Annotated[
        str, typer.Argument(metavar="PREDICTED", help="A CSV (t_s, height_mm), or a plan folder and a cup as DIR:CUP.")
    ],
    measured: Annotated[Path, typer.Argument(metavar="MEASURED.csv", help="The measured height: t_s, height_mm.")],
    figure: Annotated[
        Path | None,
        typer.Option("-o", "--output", metavar="FIG", help="Draw both (.png, .pdf or .svg).", show_default=False),
    ] = None,
) -> int:
    """Compare a predicted liquid height with a measured one; the clocks are aligned by best correlation."""
    from nospill.simulation.compare import compare as compare_heights
    from nospill.simulation.compare import predicted_heights
    from nospill.simulation.motion_file import read_heights

    if figure is not None:
        from nospill.plots.comparison import require_figure_name

        require_figure_name(figure)
    found = compare_heights(predicted_heights(predicted), read_heights(measured))
    print_table(
        ("figure", "value", "unit"),
        [
            ("predicted peak", 1e3 * found.predicted_peak, "mm"),
            ("measured peak", 1e3 * found.measured_peak, "mm"),
            ("peak error", 1e3 * found.peak_error, "mm"),
            ("peak error", 1e2 * found.relative_peak_error, "%"),
            ("root mean square error", 1e3 * found.rmse, "mm"),
            ("correlation", found.correlation, ""),
            ("integral error", 1e2 * found.integral_error, "%"),
            ("clock shift", found.shift, "s"),
        ],
    )
    if figure is not None:
        from nospill.plots.comparison import save_comparison

        save_comparison(found, figure)
        print(f"drawn to {figure}")
    return 0
