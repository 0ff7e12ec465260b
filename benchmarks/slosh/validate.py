"""The slosh model against measured motions: the table in docs/slosh-model.md.

    python -m benchmarks.slosh.validate            print the table and write it into the page
    python -m benchmarks.slosh.validate --print    print it only

The variable NOSPILL_DATA names the folder of the measurements: slosh-runs (NAME.motion.csv, NAME.height.csv)
and matrix-d3. Nothing is fitted to a run but the clock of the height, by best correlation; the container is the same in
all runs. After its end a motion is held for another 0.3 durations, so that the swinging on is compared too.
"""

from __future__ import annotations

import argparse
import os
import time
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from scipy.spatial.transform import Rotation

import nospill as ns
from nospill.robots.kinematics.forward import kinematics
from nospill.scene.cargo import Cargo
from nospill.simulation.compare import Comparison, compare
from nospill.simulation.motion_file import Heights, Motion, checked_motion, read_heights, read_motion
from nospill.simulation.readings import Model
from nospill.simulation.simulate import HeightRule, simulate_slosh

REPOSITORY = Path(__file__).resolve().parents[2]
PAGE = REPOSITORY / "docs" / "slosh-model.md"
BEGIN, END = "<!-- validation table: begin -->", "<!-- validation table: end -->"

CUP = {"shape": "cylinder", "radius": "49 mm", "height": "150 mm", "liquid": "water", "liquid_height": "80 mm"}
"""The container of all runs."""

REST = 1.0
"""s; rest before the motion in every file of the runs."""
AFTERWARDS = 0.3
"""Durations of the motion that are compared after its end."""


@dataclass(frozen=True)
class Rule:
    """How the height is predicted.

    Attributes:
        title: in the table.
        modes: liquid modes in each direction.
        height: of the surface.
        model: what the gauge reads.
        damping: ratio of the first mode in the container of the runs, None for that of the liquid and its walls.
    """

    title: str
    modes: int
    height: HeightRule = "one-mode"
    model: Model = "surface"
    damping: float | None = None


RULES = (
    Rule("one mode", 1),
    Rule("two modes (default)", 2),
    Rule("one mode, corrected", 1, "corrected"),
    Rule("contact line", 20, model="contact-line", damping=0.015),
)


@dataclass(frozen=True)
class Medians:
    """A table in four figures: median correlation, median rmse in m, median |peak error|, least peak error."""

    correlation: float
    rmse: float
    peak_error: float
    worst_under: float


def data_folder() -> Path:
    """Where the measurements are."""
    return Path(os.environ.get("NOSPILL_DATA", REPOSITORY.parent / "shared" / "data"))


def held(motion: Motion, duration: float) -> Motion:
    """The motion with its last pose kept for `duration` s."""
    step = float(np.median(np.diff(motion.t)))
    count = int(duration / step)
    return checked_motion(
        np.concatenate([motion.t, motion.t[-1] + step * np.arange(1, count + 1)]),
        np.concatenate([motion.position, np.repeat(motion.position[-1:], count, axis=0)]),
        np.concatenate([motion.quaternion, np.repeat(motion.quaternion[-1:], count, axis=0)]),
    )


def compare_runs(folder: Path) -> dict[str, tuple[Comparison, ...]]:
    """Every run of a folder with every rule: run -> one comparison per rule."""
    found = {}
    for file in sorted(folder.glob("*.motion.csv")):
        name = file.name.removesuffix(".motion.csv")
        motion = read_motion(file)
        motion = held(motion, AFTERWARDS * (motion.t[-1] - REST))
        measured = read_heights(folder / f"{name}.height.csv")
        found[name] = tuple(compare(_simulated(CUP, motion, rule), measured) for rule in RULES)
    return found


def compare_published_experiment(folder: Path) -> dict[str, tuple[Comparison, ...]]:
    """The measured cups of the published liquid motion, predicted from the joints the robot was sent."""
    scene = ns.load("matrix-liquid")
    joints = np.loadtxt(folder / "executed-joints-liquid.csv", delimiter=",", skiprows=1)
    # The laboratory's flange is turned by half a turn against the catalogue's.
    position, rotation = kinematics(scene.robot).poses(
        joints[:, 1:], tool=replace(scene.tray.tool, yaw=scene.tray.tool.yaw + np.pi)
    )
    found = {}
    for cargo in scene.cargo:
        file = folder / f"measured-height-{cargo.name}.csv"
        if not file.is_file():
            continue
        place = position + rotation @ np.append(cargo.position, 0.0)
        attitude = (Rotation.from_matrix(rotation) * Rotation.from_euler("z", cargo.yaw)).as_quat()
        motion = checked_motion(joints[:, 0], place, attitude)
        motion = held(motion, AFTERWARDS * (motion.t[-1] - motion.t[0]))
        measured = read_heights(file)
        found[f"published arc, cup {cargo.name}"] = tuple(
            compare(_simulated(cargo, motion, rule), measured) for rule in RULES
        )
    return found


def medians(runs: Mapping[str, tuple[Comparison, ...]], rule: int) -> Medians:
    """The four figures of one rule."""
    ours = [comparisons[rule] for comparisons in runs.values()]
    return Medians(
        correlation=float(np.median([run.correlation for run in ours])),
        rmse=float(np.median([run.rmse for run in ours])),
        peak_error=float(np.median([abs(run.relative_peak_error) for run in ours])),
        worst_under=min(run.relative_peak_error for run in ours),
    )


def table(runs: Mapping[str, tuple[Comparison, ...]], published: Mapping[str, tuple[Comparison, ...]]) -> str:
    """The markdown between the marks."""
    titles = [rule.title for rule in RULES]
    lines = [
        "| run | measured peak mm | " + " | ".join(f"{title}: r, rmse mm, peak" for title in titles) + " |",
        "|---|---|" + "---|" * len(titles),
    ]
    for name, comparisons in (*runs.items(), *published.items()):
        cells = [
            f"{run.correlation:.3f}, {1e3 * run.rmse:.2f}, {1e2 * run.relative_peak_error:+.1f} %"
            for run in comparisons
        ]
        lines.append(f"| {name} | {1e3 * comparisons[0].measured_peak:.1f} | " + " | ".join(cells) + " |")
    lines += [
        "",
        f"Over the {len(runs)} runs (the published arc, another cup and camera, left out):",
        "",
        "| | " + " | ".join(titles) + " |",
        "|---|" + "---|" * len(titles),
    ]
    summaries = [medians(runs, index) for index in range(len(RULES))]
    rows = (
        ("median correlation", [f"{item.correlation:.3f}" for item in summaries]),
        ("median rmse", [f"{1e3 * item.rmse:.2f} mm" for item in summaries]),
        ("median absolute peak error", [f"{1e2 * item.peak_error:.1f} %" for item in summaries]),
        ("lowest predicted peak", [f"{1e2 * item.worst_under:+.1f} %" for item in summaries]),
    )
    lines += [f"| {title} | " + " | ".join(cells) + " |" for title, cells in rows]
    return "\n".join(lines)


def write_into_page(text: str, page: Path = PAGE) -> None:
    """Replace what stands between the marks of the page."""
    old = page.read_text(encoding="utf-8")
    head, _, rest = old.partition(BEGIN)
    _, mark, tail = rest.partition(END)
    if not mark:
        raise SystemExit(f"{page}: the marks {BEGIN} and {END} are missing")
    page.write_text(f"{head}{BEGIN}\n{text}\n{END}{tail}", encoding="utf-8")


def _simulated(container: Cargo | Mapping[str, Any], motion: Motion, rule: Rule) -> Heights:
    if rule.damping is not None and isinstance(container, Mapping):
        container = {**container, "damping": rule.damping}
    poses = motion.t, motion.position, motion.quaternion
    return simulate_slosh(container, *poses, modes=rule.modes, height=rule.height, model=rule.model).heights


def main() -> None:
    """Run everything, print it, write the page."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").partition("\n")[0])
    parser.add_argument("--print", action="store_true", dest="only_print", help="leave the page as it is")
    only_print = parser.parse_args().only_print
    folder = data_folder()
    if not (folder / "slosh-runs").is_dir():
        raise SystemExit(f"{folder / 'slosh-runs'}: no such folder; set NOSPILL_DATA to the folder of the measurements")
    start = time.perf_counter()
    runs = compare_runs(folder / "slosh-runs")
    published = compare_published_experiment(folder / "matrix-d3") if (folder / "matrix-d3").is_dir() else {}
    text = table(runs, published)
    print(text)
    print(f"\n{len(RULES) * (len(runs) + len(published))} simulations in {time.perf_counter() - start:.1f} s")
    if not only_print:
        write_into_page(text)


if __name__ == "__main__":
    main()
