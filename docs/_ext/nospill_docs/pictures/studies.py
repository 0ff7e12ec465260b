"""Pictures of studies: margins of one plan, corners of tolerances, measured liquids, the campaign, planning times."""

from __future__ import annotations

import gzip
import json
import re
from collections import Counter
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure

from nospill.certification.certificate import judge
from nospill.certification.verdict import Trace
from nospill.margins import Ranges
from nospill.margins.study import margins
from nospill.plans.plan import Plan
from nospill.plots.margins_tornado import Bar, tornado_figure
from nospill.plots.style import BLACK, BLUE, GREEN, GREY, ORANGE, draw_limit
from nospill.scenario import scene_from_table
from nospill_docs.pictures.paper import WIDTH, sheet

READS = (
    "slosh-model.md",
    "../benchmarks/results/summary.json",
    "../src/nospill/margins/study.py",
    "../src/nospill/margins/laws.py",
)
"""What its pictures read, from docs/."""
_ROOT = Path(__file__).parents[4]
_SAMPLES = 300


def tornado(plan: Plan) -> Figure:
    """Which number matters most to a plan: a small study of its margins."""
    report = margins(plan, ranges=Ranges(), samples=_SAMPLES, seed=1)
    bars = [
        Bar(i.factor, i.measure, i.nominal, i.least, i.greatest, i.least_at, i.greatest_at, i.limited_by)
        for i in report.influences
    ]
    figure = tornado_figure(
        bars[:6], report.worst_margin, nominal=report.nominal, title=f"{report.scenario}: what the margin depends on"
    )
    figure.set_size_inches(WIDTH, figure.get_size_inches()[1])
    return figure


def corners(stated: Plan, robust: Plan) -> Figure:
    """Height of one liquid at the corners of its tolerance: planned for the stated numbers, and for them all."""
    figure = sheet(2.7)
    both = figure.subplots(1, 2, sharey=True)
    figure.subplots_adjust(left=0.075, right=0.985, top=0.88, bottom=0.17, wspace=0.06)
    for axes, plan, title in zip(
        both, (stated, robust), ("planned for the stated numbers", "planned for the tolerances"), strict=True
    ):
        highest = limit = 0.0
        for offset, factor, look in (
            (0.0, 1.0, {"color": BLACK, "linewidth": 1.6, "label": "as stated"}),
            (2.0, 0.5, {"color": BLUE, "linewidth": 1.0, "label": "2 mm more, half the damping"}),
            (
                -2.0,
                0.5,
                {"color": ORANGE, "linewidth": 1.0, "linestyle": (0, (5, 1.6)), "label": "2 mm less, half the damping"},
            ),
        ):
            trace = _judged_at(plan, offset, factor)
            limit = 1e3 * float(trace.limit[0])
            axes.plot(trace.t, 1e3 * trace.value, **look)
            highest = max(highest, 1e3 * float(np.max(trace.value)))
        top = 1.12 * limit
        axes.set_ylim(limit - 5.0, top)
        draw_limit(axes, limit, f"limit {limit:g} mm", forbidden=top)
        axes.set_xlim(0.0, plan.duration)
        axes.set_title(f"{title}: {plan.duration:.2f} s")
        axes.set_xlabel("time [s]")
        axes.text(0.98, 0.95, f"highest {highest:.1f} mm", transform=axes.transAxes, ha="right", va="top", size=8.5)
    both[0].set_ylabel("height of c1 [mm]")
    both[0].legend(
        loc="lower left", bbox_to_anchor=(0.2, 0.0), framealpha=1.0, frameon=True, edgecolor="none", borderpad=0.2
    )
    return figure


def _judged_at(plan: Plan, offset: float, factor: float) -> Trace:
    """Height of the first cup where all are filled so many mm higher and damped so many times as much."""
    table = plan.scene.source
    table.pop("tolerance", None)
    for entry, cargo in zip(table["cargo"], plan.scene.cargo, strict=True):
        assert cargo.filling is not None
        # The masses, which say nothing of the height, would not fit another level.
        entry.pop("mass", None), entry.pop("centre_of_mass_height", None)
        entry["empty_mass"] = 0.01
        entry["liquid_height"] = cargo.filling.liquid_height + 1e-3 * offset
        entry["damping"] = factor * cargo.filling.modes.oscillators[0].damping
    judgement = judge(plan.trajectory, scene_from_table(table, name=plan.scene.name))
    return next(item for item in judgement.traces if item.constraint == "slosh height")


def measured_peaks() -> Figure:
    """Predicted over measured peaks of the runs in the table of the page on the slosh model."""
    rows = re.findall(
        r"^\| (\S.*?) \| ([\d.]+)" + 4 * r" \| [^|]*?([+-][\d.]+) %" + r" \|$",
        (_ROOT / "docs" / "slosh-model.md").read_text(encoding="utf-8"),
        flags=re.MULTILINE,
    )
    figure = sheet(2.9)
    axes = figure.add_axes((0.075, 0.16, 0.42, 0.74))
    errors = figure.add_axes((0.6, 0.16, 0.385, 0.74))
    measured = np.array([float(row[1]) for row in rows])
    looks = (
        ("one mode", BLACK, "o"),
        ("two modes", BLUE, "s"),
        ("one, corrected", ORANGE, "^"),
        ("contact line", GREEN, "D"),
    )
    top = 62.0
    axes.fill_between((0.0, top), (0.0, 0.9 * top), (0.0, 1.1 * top), color="#E8E8E8", linewidth=0)
    axes.plot((0.0, top), (0.0, top), color=GREY, linewidth=1.0)
    for column, (name, colour, marker) in enumerate(looks):
        error = np.array([float(row[2 + column]) for row in rows])
        axes.plot(measured, measured * (1 + error / 100), marker, color=colour, markersize=4, label=name, alpha=0.85)
        errors.plot(
            np.sort(error), np.arange(1, len(error) + 1), color=colour, marker=marker, markersize=3.5, linewidth=1.0
        )
    axes.set_xlim(10.0, top)
    axes.set_ylim(10.0, top)
    axes.set_title("Highest liquid of 23 motions")
    axes.set_xlabel("measured [mm]")
    axes.set_ylabel("predicted [mm]")
    axes.legend(loc="upper left", handletextpad=0.2)
    axes.text(61.0, 40.0, "grey: within 10 %", ha="right", size=8, color="#333333")
    errors.axvline(0.0, color=GREY, linewidth=1.0)
    errors.set_title("Errors of the peak, sorted")
    errors.set_xlabel("predicted less measured [%]")
    errors.set_ylabel("motions up to here [1]")
    return figure


def campaign() -> Figure:
    """How the random scenarios of the campaign ended, and how long planning took."""
    lines = gzip.decompress((_ROOT / "benchmarks" / "results" / "campaign.jsonl.gz").read_bytes()).decode().splitlines()
    cases: dict[int, dict[str, Any]] = {}
    for line in lines:
        entry = json.loads(line)
        if "plan_processor_s" in entry or "reason" in entry:
            cases[entry["seed"]] = entry
    figure = sheet(2.6)
    bars = figure.add_axes((0.16, 0.18, 0.3, 0.7))
    times = figure.add_axes((0.56, 0.18, 0.425, 0.7))
    counts = Counter(case["kind"] for case in cases.values())
    for row, (_, count) in enumerate(counts.most_common()):
        bars.barh(row, count, height=0.6, color=BLUE if row == 0 else GREY)
        bars.text(count + 12, row, f"{count}", va="center", size=8.5)
    bars.set_yticks(range(len(counts)), [name for name, _ in counts.most_common()])
    bars.invert_yaxis()
    bars.set_xlim(0, 1.2 * max(counts.values()))
    bars.grid(axis="y", visible=False)
    bars.set_title(f"{len(cases)} random scenarios")
    bars.set_xlabel("cases [1]")
    seconds = np.sort([case["plan_processor_s"] for case in cases.values() if case["kind"] == "planned"])
    times.plot(seconds, np.linspace(0.0, 100.0, len(seconds)), color=BLUE)
    for share in (50, 90):
        at = float(np.percentile(seconds, share))
        times.plot(at, share, "o", color=BLACK, markersize=4)
        times.annotate(
            f"{share} % within {at:.3g} s",
            (at, share),
            xytext=(7, -4),
            textcoords="offset points",
            size=8.5,
            ha="left",
            va="top",
            annotation_clip=False,
        )
    times.set_xscale("log")
    times.set_title("Processor time until planned")
    times.set_xlabel("time [s]")
    times.set_ylabel("share of the planned [%]")
    return figure


def planning_times() -> Figure:
    """Planning times as bars: cold plans and warm ones, and the published transcription."""
    found = json.loads((_ROOT / "benchmarks" / "results" / "summary.json").read_text(encoding="utf-8"))["measurements"]
    groups = {
        "four cups, tilting, twenty modes": (
            ("first plan of a process", "cold matrix-liquid-tilt"),
            ("changed fill, planned again", "warm matrix-liquid-tilt"),
        ),
        "cups, box and bottle, tilting, twenty modes": (
            ("first plan of a process", "cold mixed-tray"),
            ("changed fill, planned again", "warm mixed-tray"),
        ),
        "four cups, level, one mode": (
            ("published transcription", "baseline liquid"),
            ("without a compiler", "one mode: no compiler matrix-liquid"),
            ("first plan of a process", "one mode: cold matrix-liquid"),
            ("changed fill, planned again", "one mode: warm matrix-liquid"),
        ),
        "four solids, tilting": (
            ("published transcription", "baseline rigid"),
            ("without a compiler", "one mode: no compiler matrix-rigid"),
            ("first plan of a process", "one mode: cold matrix-rigid"),
        ),
    }
    figure = sheet(4.3)
    axes = figure.add_axes((0.29, 0.11, 0.69, 0.83))
    line, ticks, names = 0.0, [], []
    for title, rows in groups.items():
        axes.text(0.011, line, title, weight="bold", size=9, va="center")
        line += 0.9
        for name, key in rows:
            one = found[key]
            seconds = float(np.median((one["changes"]["fill level"] if "changes" in one else one)["all_processor"]))
            look = (
                {"color": "white", "edgecolor": GREY, "hatch": "////"}
                if key.startswith("baseline")
                else {"color": BLUE}
            )
            axes.barh(line, seconds, left=0.0, height=0.62, **look)
            mark = "" if one.get("status", "Solve_Succeeded") == "Solve_Succeeded" else ", not converged"
            axes.text(1.08 * seconds, line, f"{seconds:.3g} s{mark}", va="center", size=8.5)
            ticks.append(line)
            names.append(name)
            line += 0.8
        line += 0.45
    axes.set_yticks(ticks, names)
    axes.set_ylim(line - 0.4, -0.6)
    axes.set_xscale("log")
    axes.set_xlim(0.01, 3000.0)
    axes.set_xlabel("processor time until a motion is certified [s], logarithmic")
    axes.grid(axis="y", visible=False)
    axes.tick_params(axis="y", length=0)
    return figure
