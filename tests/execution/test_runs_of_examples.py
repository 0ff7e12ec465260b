"""Bundled examples as they would be run: their own files, and logs of sensors."""

from __future__ import annotations

from pathlib import Path

import pytest

from benchmarks.executed.run import verdict, write_run
from nospill.execution.bands import CERTIFIED, NOT_CERTIFIED, OPEN
from nospill.execution.executed import executed
from nospill.execution.reading import read_log
from nospill.plans.plan import Plan
from tests.builders import with_few_speeds
from tests.execution.logs import log_of

pytestmark = pytest.mark.usefixtures("verdict_alone")

OWN_FILE = ("matrix-rigid", "shelf-to-table")
"""Solids, and a free path with a file of an interface; the others are read in the same way."""


@pytest.mark.slow
@pytest.mark.parametrize("name", OWN_FILE)
def test_an_example_s_own_file_is_certified_as_the_plan(name: str, example_plan, tmp_path: Path) -> None:
    plan: Plan = example_plan(name)
    with_few_speeds(plan).save(tmp_path / "plan")
    file = tmp_path / "plan" / "robot.csv"
    log = read_log(file, plan.scene.robot) if file.is_file() else log_of(plan, noise=0.0, jitter=0.0)
    found = executed(log, plan.scene, plan=plan)
    assert found.ok and found.word == plan.certificate.word
    assert "corridor" not in {row.constraint for row in found.judgement.certificate.rows}


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "rate", "noise", "jitter"),
    [  # noise at the lowest and the highest rate, none between; matrix-liquid in test_executed.py, at every rate
        ("matrix-rigid", 1000.0, 1e-4, 3e-4),
        ("pp-two-cups", 125.0, 1e-4, 3e-4),
        ("shelf-to-table", 250.0, 0.0, 3e-4),
    ],
)
def test_a_run_as_planned_is_not_refused(name: str, example_plan, rate: float, noise: float, jitter: float) -> None:
    plan: Plan = example_plan(name)
    found = executed(log_of(plan, rate=rate, noise=noise, jitter=jitter), plan.scene, plan=plan)
    assert found.outcome != NOT_CERTIFIED, [str(key) for key, word in found.outcomes.items() if word == NOT_CERTIFIED]


@pytest.mark.slow
@pytest.mark.parametrize(("name", "rate"), [("matrix-rigid", 125.0), ("pp-two-cups", 1000.0)])
def test_samples_taken_at_uneven_stamps_are_not_refused(name: str, example_plan, rate: float, tmp_path: Path) -> None:
    plan: Plan = example_plan(name)
    word, rows = verdict(plan, write_run(plan, tmp_path / "run.csv", rate, at_stamps=True))
    assert word in (CERTIFIED, OPEN), rows
