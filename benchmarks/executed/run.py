"""Whether runs as planned pass `executed`: every bundled example, its own file and what recorders write of it.

    python -m benchmarks.executed.run --plans FOLDER               all examples, planned into FOLDER where they are not
    python -m benchmarks.executed.run --plans FOLDER vial-rack     one of them

A line for each log, and at the end how many were certified, could not be told, or were refused.
"""

from __future__ import annotations

import argparse
import tempfile
import time
from collections import Counter
from pathlib import Path

import numpy as np

import nospill as ns
from nospill.core.files import atomic_text
from nospill.errors import NospillError
from nospill.execution.executed import executed
from nospill.execution.reading import read_log
from nospill.execution.record import failing, undecided
from nospill.export.joint_csv import CSV
from nospill.plans.handover import hand_over
from nospill.plans.plan import Plan
from nospill.scenario.examples import EXAMPLES

RATES = (125.0, 250.0, 500.0, 1000.0)
NOISE, JITTER = 1e-4, 3e-4
"""Standard deviation of a position, rad; the most by which a stamp is off an even clock, s."""
_REST = 0.5
"""s; recorded before and after the motion."""


def write_run(plan: Plan, path: Path, rate: float, *, at_stamps: bool, seed: int = 3) -> Path:
    """What a recorder writes of a plan that is played as it is.

    Args:
        plan: that is played.
        path: of the table.
        rate: rows a second.
        at_stamps: whether positions are taken when the stamps say, or evenly, with stamps that are late or early.
        seed: of noise and jitter.
    """
    generator = np.random.default_rng(seed)
    t = np.arange(round((plan.duration + 2.0 * _REST) * rate)) / rate
    stamps = t + JITTER * generator.uniform(-1.0, 1.0, len(t))
    position = plan.trajectory.motion((stamps if at_stamps else t) - _REST)
    position = position + NOISE * generator.standard_normal(position.shape)
    rows = (",".join(f"{value:.9f}" for value in row) for row in np.column_stack([stamps - stamps[0], position]))
    atomic_text(path, "\n".join([",".join(["t_s", *plan.scene.robot.joints]), *rows, ""]))
    return path


def own_file(plan: Plan, folder: Path) -> Path:
    """The file of the plan that a controller plays: the laboratory's where it can be written, or a table of joints."""
    saved = folder / "robot.csv"
    return saved if saved.is_file() else hand_over(plan, CSV, folder.parent / f"{folder.name}.joints.csv").path


def verdict(plan: Plan, log: Path) -> tuple[str, str]:
    """Outcome of a log, and the rows that keep it from being certified."""
    try:
        found = executed(read_log(log, plan.scene.robot), plan.scene, plan=plan)
    except NospillError as error:
        return "refused", str(error)
    rows = [
        f"{row.constraint} of {row.subject} {100.0 * row.use:.1f} %" for row in (*failing(found), *undecided(found))
    ]
    return found.outcome, ", ".join(rows)


def main() -> None:
    """Run and report."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("names", nargs="*", help="of the examples; all where none is given")
    parser.add_argument("--plans", type=Path, required=True, help="folder of plan folders")
    options = parser.parse_args()
    outcomes: Counter[str] = Counter()
    for name in options.names or EXAMPLES:
        folder = options.plans / name
        if not folder.is_dir():
            ns.plan(name).save(folder)
        plan = ns.load_plan(folder)
        with tempfile.TemporaryDirectory() as place:
            logs = {"own file": own_file(plan, folder)}
            for rate in RATES:
                for at_stamps in (False, True):
                    label = f"{rate:g} Hz, {'taken at the stamps' if at_stamps else 'taken evenly'}"
                    path = Path(place) / f"{rate:g}-{at_stamps}.csv"
                    logs[label] = write_run(plan, path, rate, at_stamps=at_stamps)
            for label, log in logs.items():
                began = time.process_time()
                word, rows = verdict(plan, log)
                outcomes[word] += 1
                took = time.process_time() - began
                print(f"{name}, {label}: {word} ({took:.1f} s){': ' if rows else ''}{rows}", flush=True)
    print(dict(outcomes))


if __name__ == "__main__":
    main()
