"""Pictures of a certificate: its columns, what is between two samples, what warnings look at, the controls."""

from __future__ import annotations

import numpy as np
from matplotlib.figure import Figure

from nospill.motion.interpolation import QUINTIC_HERMITE, QUINTIC_SPLINE, JointSamples
from nospill.plots.evidence import Evidence
from nospill.plots.style import BLACK, BLUE, DARK_RED, GREEN, GREY, ORANGE, RED, draw_limit
from nospill.plots.use_table import draw_use_table
from nospill_docs.pictures.paper import arrow, box, cup, sheet, sketch, words


def annotated_certificate(evidence: Evidence) -> Figure:
    """The printed certificate with what each column says."""
    rows = len(evidence.judgement.certificate.listed_rows())
    high = 0.19 * (rows + 2.6)
    figure = sheet(high + 1.75)
    table = figure.add_axes((0.01, 0.85 / (high + 1.75), 0.98, high / (high + 1.75)))
    draw_use_table(table, evidence, usual=0)
    over = sketch(figure, (0.0, 0.0, 1.0, 1.0), (0.0, 7.4), (0.0, high + 1.75))
    top = high + 0.85
    for x, to, text in (
        (0.06, 0.35, "which limit"),
        (1.45, 1.8, "whose: object, joint,\ntray or path"),
        (3.05, 3.5, "the part of the limit that is used;\nthe red line is the limit"),
        (5.25, 5.5, "reached, and\nallowed"),
        (6.55, 7.15, "when it was\nnearest"),
    ):
        words(over, (x, top + 0.5), text, size=8.5, va="center")
        arrow(over, (to, top + 0.27), (to, top - 0.02), color=GREY, width=1.0)
    fullest = evidence.judgement.certificate.listed_rows()[0]
    words(
        over,
        (0.1, 0.42),
        f"The fullest row, {fullest.constraint} of {fullest.subject}, is nearest to its limit. "
        "A use is rounded down where\n"
        "the limit holds, so 99.9 % is never a broken limit. Rows about the file itself stand in the last line.",
        size=8.5,
    )
    return figure


def between_samples(evidence: Evidence) -> Figure:
    """What a controller makes of the samples, and how finely the judge looks."""
    figure = sheet(2.7)
    whole, close = figure.subplots(1, 2)
    figure.subplots_adjust(left=0.085, right=0.985, top=0.88, bottom=0.17, wspace=0.27)
    trace = next(item for item in evidence.traces("slosh height") if item.subject == "c1")
    limit = 1e3 * float(trace.limit[0])
    whole.plot(trace.t, 1e3 * trace.value, color=BLUE)
    whole.set_xlim(0.0, evidence.end_time)
    whole.set_ylim(0.0, 1.25 * limit)
    draw_limit(whole, limit, f"limit {limit:g} mm", forbidden=1.25 * limit)
    at = int(np.argmax(trace.value))
    low, high = trace.t[at] - 0.012, trace.t[at] + 0.012
    whole.axvspan(float(low) - 0.01, float(high) + 0.01, color="#DDDDDD")
    whole.set_title("Liquid of c1, played again")
    picked = (trace.t > low) & (trace.t < high)
    close.plot(
        1e3 * (trace.t[picked] - low),
        1e3 * trace.value[picked],
        color=BLUE,
        marker=".",
        markersize=4,
        label="judge, every 0.5 ms",
    )
    nodes = evidence.plan.trajectory.t
    nodes = nodes[(nodes > low) & (nodes < high)]
    close.plot(
        1e3 * (nodes - low),
        np.interp(nodes, trace.t, 1e3 * trace.value),
        "s",
        color=BLACK,
        markersize=5,
        label="samples of the file, every 2 ms",
    )
    span = 1e3 * float(np.ptp(trace.value[picked]))
    close.set_ylim(1e3 * float(trace.value[picked].min()) - 0.3 * span, limit + 0.8 * span)
    draw_limit(close, limit, "limit", forbidden=limit + 0.8 * span)
    close.set_title("The shaded part")
    close.legend(loc="lower center")
    whole.set_xlabel("time [s]")
    close.set_xlabel("time [ms]")
    for axes in (whole, close):
        axes.set_ylabel("height at the wall [mm]")
    return figure


def coarse_samples() -> Figure:
    """The same motion written at a coarse rate: what two ways of playing it make of its corners."""
    figure = sheet(2.6)
    place, jerk = figure.subplots(1, 2)
    figure.subplots_adjust(left=0.085, right=0.985, top=0.88, bottom=0.18, wspace=0.24)
    fine = np.arange(0.0, 0.2501, 0.0005)
    acceleration = 40.0 * np.interp(fine, [0.0, 0.05, 0.15, 0.2, 0.25], [0.0, 1.0, -1.0, 0.0, 0.0])
    speed = np.concatenate([[0.0], np.cumsum(0.5 * (acceleration[1:] + acceleration[:-1]) * 0.0005)])
    position = np.concatenate([[0.0], np.cumsum(0.5 * (speed[1:] + speed[:-1]) * 0.0005)])
    every = 40
    samples = JointSamples(fine[::every], position[::every, None], speed[::every, None], acceleration[::every, None])
    place.plot(fine, position, color=GREY, linewidth=3.0, label="planned")
    jerk.plot(fine, acceleration, color=GREY, linewidth=3.0, label="planned")
    played = (
        (QUINTIC_SPLINE, "one quintic spline", BLUE, "-"),
        (QUINTIC_HERMITE, "a quintic each segment", ORANGE, (0, (5, 1.6))),
    )
    for way, name, colour, dashes in played:
        motion = way.motion(samples)
        place.plot(fine, motion(fine)[:, 0], color=colour, linestyle=dashes)
        jerk.plot(fine, motion(fine, 2)[:, 0], color=colour, linestyle=dashes, label=name)
    place.plot(samples.t, samples.position, "s", color=BLACK, markersize=4, zorder=5)
    jerk.plot(samples.t, samples.acceleration, "s", color=BLACK, markersize=4, zorder=5)
    place.set_title("Position of a joint, 50 samples a second")
    jerk.set_title("Its acceleration")
    place.set_ylabel("position [rad]")
    jerk.set_ylabel("acceleration [rad/s²]")
    jerk.legend(loc="upper right")
    for axes in (place, jerk):
        axes.set_xlabel("time [s]")
        axes.set_xlim(0.0, 0.25)
    return figure


def warnings() -> Figure:
    """What the warnings about a liquid look at: crest, distance to the rim, surface tension."""
    figure = sheet(2.75)
    axes = sketch(figure, (0.0, 0.0, 0.5, 1.0), (-2.4, 3.1), (-0.35, 3.6))
    cup(axes, radius=1.0, height=3.0, level=1.8, slope=0.62)
    axes.plot([-1.0, 1.0], [1.8, 1.8], color=BLUE, linewidth=0.9, linestyle=(0, (4, 1.5)), zorder=5)
    axes.plot([-1.05, 1.05], [1.8 + 1 / 3, 1.8 + 1 / 3], color=RED, linewidth=1.3, zorder=5)
    axes.plot([-1.05, 1.05], [2.88, 2.88], color=RED, linewidth=1.3, linestyle=(0, (4, 1.5)), zorder=5)
    arrow(axes, (1.25, 1.8), (1.25, 2.42), width=1.1, style="<|-|>")
    words(axes, (1.35, 2.3), "crest: above a third of\nthe radius the linear\nsurface is doubtful", size=8.5, va="top")
    arrow(axes, (1.25, 2.88), (1.25, 3.0), width=1.1, style="-")
    words(axes, (1.35, 3.15), "distance to the rim:\nless than the reserve\n(freeboard_reserve)", size=8.5)
    words(axes, (-1.1, 1.8 + 1 / 3), "R/3", ha="right", size=8.5, color=DARK_RED)
    words(axes, (-1.1, 2.88), "reserve", ha="right", size=8.5, color=DARK_RED)
    words(axes, (-1.1, 1.8), "at rest", ha="right", size=8.5)
    shift = figure.add_axes((0.58, 0.18, 0.405, 0.7))
    radius = np.linspace(0.01, 0.06, 200)
    for name, tension, density, colour, dashes in (
        ("water", 0.072, 998.0, BLUE, "-"),
        ("ethanol", 0.022, 789.0, GREEN, (0, (5, 1.6))),
    ):
        bond = density * 9.80665 / (tension * (1.8412 / radius) ** 2)
        shift.plot(1e3 * radius, 100 * (np.sqrt(1 + 1 / bond) - 1), color=colour, linestyle=dashes, label=name)
    shift.set_ylim(0.0, 8.0)
    draw_limit(shift, 2.0, "warning above 2 %", forbidden=8.0, align="right")
    shift.set_xlim(10.0, 60.0)
    shift.set_title("Surface tension and the first frequency")
    shift.set_xlabel("radius of the cup [mm]")
    shift.set_ylabel("frequency too low by [%]")
    shift.legend(loc="upper right")
    return figure


def chain_of_integrators(evidence: Evidence) -> Figure:
    """The states and the control of a plan: path parameter, its rates, and the jerk that steers them."""
    figure = sheet(3.6)
    axes = figure.subplots(4, 1, sharex=True)
    figure.subplots_adjust(left=0.1, right=0.985, top=0.94, bottom=0.12, hspace=0.22)
    trajectory = evidence.plan.trajectory
    kept = trajectory.t <= evidence.end_time + 1e-9
    t = trajectory.t[kept]
    jerk = np.gradient(trajectory.s_acceleration[kept], t)
    for row, (values, name) in enumerate(
        (
            (trajectory.s[kept], "$s$ [1]"),
            (trajectory.s_rate[kept], "$\\dot s$ [1/s]"),
            (trajectory.s_acceleration[kept], "$\\ddot s$ [1/s²]"),
            (jerk, "jerk [1/s³]"),
        )
    ):
        axes[row].plot(t, values, color=ORANGE if row == 3 else BLUE)
        axes[row].set_ylabel(name)
        axes[row].margins(y=0.12)
        axes[row].axhline(0.0, color=GREY, linewidth=0.8)
    axes[0].set_title("Three states along the path, and the control below them: rest to rest", size=9)
    axes[3].set_xlabel("time [s]")
    axes[0].set_xlim(0.0, evidence.end_time)
    figure.align_ylabels()
    return figure


def certificate_in_steps() -> Figure:
    """How the verdict is made, from the file to the rows."""
    figure = sheet(1.55)
    axes = sketch(figure, (0.0, 0.0, 1.0, 1.0), (0.0, 7.4), (0.0, 1.55))
    steps = (
        ("samples", "joints in the file,\none row every 2 ms"),
        ("motion", "quintic spline, as\nthe controller plays"),
        ("tray", "forward kinematics,\n2 kHz or finer"),
        ("liquids", "integrated through it,\ntwo grids agree"),
        ("rows", "value, limit, margin;\nthe worst instant"),
    )
    for number, (name, text) in enumerate(steps):
        x = 0.05 + 1.48 * number
        box(axes, (x, 0.2), (1.28, 1.1))
        words(axes, (x + 0.64, 1.02), name, ha="center", weight="bold")
        words(axes, (x + 0.64, 0.57), text, ha="center", size=8)
        if number:
            arrow(axes, (x - 0.19, 0.75), (x - 0.01, 0.75), color=GREY)
    return figure
