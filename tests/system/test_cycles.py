"""The bundled cycles: certified, as long as they say, and shorter than with legs that rest."""

from __future__ import annotations

import pytest

import nospill as ns
from nospill.planning.planner import plan
from nospill.scenario.examples import CYCLES
from tests.cycles import small_plan

FOUND = [("matrix-cycle", ["fidelity=deliverable"], 4.864), ("bar-service", [], 6.694)]
"""Cycle, settings, s of the whole; with all modes matrix-cycle takes 5.108 s, and longer to plan."""
AT_REST = 7.284
"""s; bar-service with `motion.end = "still"`, planned with the command on the page; with 2 % left it is 7.750 s."""

pytestmark = pytest.mark.slow


@pytest.mark.parametrize(("name", "settings", "duration"), FOUND)
def test_a_bundled_cycle_is_certified_and_as_long_as_it_says(name: str, settings: list[str], duration: float) -> None:
    found = ns.plan_cycle(ns.load_cycle(name, settings=settings))
    assert found.certificate.ok, found.certificate.finding
    assert found.duration == pytest.approx(duration, rel=5e-3)
    assert found.wait == 0.0  # it may begin again at once
    assert found.moves_per_hour == pytest.approx(len(found.legs) * 3600.0 / found.duration)
    assert found.unloaded_per_hour == pytest.approx(4 * found.cycles_per_hour)  # both carry four
    if name == "bar-service":
        assert found.duration < 0.95 * AT_REST


def test_every_bundled_cycle_is_planned_here() -> None:
    assert [name for name, *_ in FOUND] == list(CYCLES)


def test_no_leg_is_longer_than_alone_from_rest_to_rest() -> None:
    found = small_plan()
    for leg, planned in zip(found.cycle.legs, found.times, strict=True):
        alone = plan(leg.scene.changed({"motion.end": "still"}))
        assert alone.certificate.ok
        assert planned.motion <= alone.duration
