"""Stops of a plan: each is certified again as the plan until then and the stop after it, from rest to rest."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from typer.testing import CliRunner

import nospill as ns
from nospill.cli import app
from nospill.errors import PlanFolderError, ScenarioError
from nospill.laws.constraints import OBJECT_NAMES
from nospill.motion.interpolation import QUINTIC_SPLINE, JointSamples
from nospill.plans.plan import Plan
from nospill.plans.stops import ControllerStop, Stops, stopped
from nospill.stopping.controller import BrakedJoints, SlowedClock, braked, slowed_to_rest
from nospill.stopping.films import stop_films
from nospill.stopping.solving import splice_at
from nospill.stopping.splices import states_with_leads

EVERY = 1.2
"""s; three instants."""


@pytest.fixture(scope="module")
def plan(gentle_plan: Callable[[str, int], Plan]) -> Plan:
    """A gentle motion of one cup, which nobody had to solve."""
    return gentle_plan("matrix-liquid-soft-end", 1)


@pytest.fixture(scope="module")
def found(plan: Plan) -> Stops:
    return ns.stops(plan, every=EVERY, deceleration=[3.0, 3.0, 3.0, 6.0, 6.0, 6.0])


def test_there_is_a_stop_from_every_instant_and_none_is_longer_than_the_rest(plan: Plan, found: Stops) -> None:
    assert [stop.t for stop in found.stops] == pytest.approx([EVERY, 2 * EVERY, 3 * EVERY])
    for stop in found.stops:
        assert 0.0 < stop.bound.duration <= stop.duration
        assert stop.duration <= stop.left == pytest.approx(plan.duration - stop.t)
        assert plan.trajectory.s[round(stop.t * plan.trajectory.rate)] <= stop.end <= 1.0
    assert found.longest.duration == max(stop.duration for stop in found.stops)
    assert found.solved >= 0.5 and found.part_left < 0.6


def test_plan_until_then_and_stop_after_it_are_certified_as_one_motion_from_rest(plan: Plan, found: Stops) -> None:
    """The second opinion knows of no state: liquids and joints come from rest, as they do when somebody stops.

    It looks at a second of rest too, in which what swings on pushes its cup.
    """
    after = 1.0
    scene = replace(plan.scene, motion=replace(plan.scene.motion, residual_fraction=1.0))
    solved = [stop for stop in found.stops if stop.origin == "solved"]
    assert solved
    for stop in solved:
        np.testing.assert_allclose(stop.trajectory.tilt[-1], 0.0, atol=1e-4)
        q = stopped(plan.trajectory, stop).position
        q = np.vstack([q, np.repeat(q[-1:], round(after * plan.trajectory.rate), axis=0)])
        certificate = ns.certify_joints(np.arange(len(q)) / plan.trajectory.rate, q, scene)
        end = {"still at the end"}  # of a published plan; a stop may swing on
        assert not [row.label for row in certificate.rows if not row.ok and row.constraint not in end]


def test_a_flow_in_doubt_is_said_with_its_liquid(found: Stops) -> None:
    assert found.doubt is None  # of second order
    doubted = replace(found, stops=(*found.stops[:-1], replace(found.stops[-1], doubted=("c1",))))
    assert (doubted.doubt or "").startswith("in 1 of 3 stops the flow that judges c1 is in doubt: its surface is steep")
    assert [entry["flow_in_doubt"] for entry in doubted.to_dict()["stops"]] == [[], [], ["c1"]]


def test_braked_joints_stop_as_their_closed_form_says() -> None:
    t = np.linspace(0.0, 1.0, 101)
    before = QUINTIC_SPLINE.motion(JointSamples(t, np.column_stack([0.4 * t**3, -0.2 * t**3])))
    motion = BrakedJoints(before, 0.5, np.array([2.0, 1.0]))
    q, speed = before(np.array([0.5]))[0], before(np.array([0.5]), 1)[0]
    assert motion.duration == pytest.approx(np.max(np.abs(speed) / [2.0, 1.0]))
    np.testing.assert_allclose(motion(np.array([2.0]))[0], q + speed * np.abs(speed) / [4.0, 2.0], atol=1e-12)
    np.testing.assert_allclose(motion(np.array([2.0]), 1)[0], 0.0, atol=1e-12)


def test_a_slowed_clock_keeps_to_the_way_and_its_rates_are_its_derivatives() -> None:
    t = np.linspace(0.0, 2.0, 201)
    before = QUINTIC_SPLINE.motion(
        JointSamples(t, np.column_stack([t**3 / 8 * (2 - t) ** 3, 0.1 * t**3 * (2 - t) ** 3]))
    )
    motion, at = SlowedClock(before, 0.6, 0.4), np.linspace(0.61, 0.99, 39)
    np.testing.assert_allclose(motion(np.array([1.0, 3.0])), before(np.array([0.8, 0.8])), atol=1e-12)
    for order in (0, 1, 2):
        slope = (motion(at + 1e-5, order) - motion(at - 1e-5, order)) / 2e-5
        np.testing.assert_allclose(slope, motion(at, order + 1), atol=1e-4)


def test_a_controller_s_own_stop_is_judged(plan: Plan, found: Stops) -> None:
    """Softly braked everything holds but for what swings on; hard, the cup slides; both at the same instant."""
    assert [(item.t, item.kind) for item in found.controller[:2]] == [(EVERY, "joints"), (EVERY, "path")]
    (state,), (lead,) = states_with_leads(plan, np.array([2 * EVERY]))
    splice = splice_at(plan, state, lead)
    hard, soft = braked(splice, np.full(6, 40.0)), slowed_to_rest(splice, 4.0)
    assert not hard.certified and "slides c1" in hard.text and hard.uses["slip | c1"] > 1.0
    assert hard.duration == pytest.approx(np.max(np.abs(plan.trajectory(2 * EVERY, 1))) / 40.0)
    assert not {key.split(" | ")[0] for key in soft.uses} & {"slip", "tip", "lift"}
    assert all(key.split(" | ")[0] in OBJECT_NAMES for key in hard.uses)


def test_what_a_stop_does_is_said_in_words() -> None:
    stop = ControllerStop(0.7, "joints", 0.2, False, 0.006, {"slosh height | c1": 1.4, "slip | c2": 2.0})
    assert stop.text == "crest 6 mm too high, slides c2"
    assert replace(stop, spill=float("inf")).text == "beyond the slosh model, slides c2"
    assert replace(stop, certified=True).text == "holds"
    many = {f"tip | c{number}": 2.0 for number in range(5)}
    assert replace(stop, spill=0.0, uses=many).text == "tips 5"


def test_stops_that_cannot_be_found_are_refused(plan: Plan) -> None:
    refusals = {
        "above 0": {"deceleration": 0.0},
        "one number in rad": {"deceleration": [1.0, 2.0]},
        "every = 0 s": {"every": 0.0},
        "residual = 1.5": {"residual": 1.5},
        "slowing = nan s": {"slowing": float("nan")},
        "no instant lies within": {"every": 30.0},
    }
    for words, options in refusals.items():
        with pytest.raises(ScenarioError, match=words):
            ns.stops(plan, **options)
    with pytest.raises(ScenarioError, match="not certified"):
        ns.stops(replace(plan, certificate=replace(plan.certificate, ok=False)))
    ranged = replace(plan.scene, motion=replace(plan.scene.motion, speed_range=(0.5, 1.0)))
    with pytest.raises(ScenarioError, match="speed_range"):
        ns.stops(replace(plan, scene=ranged))


def test_the_command_writes_table_figure_and_library(plan: Plan, tmp_path: Path) -> None:
    folder = tmp_path / "plan"
    plan.save(folder)
    done = CliRunner().invoke(app, ["stops", str(folder), "--every", "3 s", "--within", "0.01 s"])
    said = done.stdout.replace("\n", " ")
    assert done.exit_code == 1 and "no safety function" in said and "not stoppable within 0.01 s" in said
    assert "at [s]" in done.stdout and "2 of 3: find the stops" in done.stderr
    table = json.loads((folder / "stops.json").read_text(encoding="utf-8"))
    assert [entry["t_s"] for entry in table["stops"]] == pytest.approx([3.0])
    assert len(table["controller"]) == 2 and (folder / "stops.png").stat().st_size > 10_000
    files = {entry["file"] for entry in table["stops"]} - {None}
    assert files == {item.name for item in (folder / "stops").iterdir()}
    assert ns.load_plan(folder).certificate.ok
    _is_shown_beside_braked_joints(folder, plan, table)
    refused = CliRunner().invoke(app, ["stops", str(folder), "--deceleration", "0 rad/s^2"])
    assert refused.exit_code == 2 and len(refused.stderr.strip().splitlines()) <= 3


def _is_shown_beside_braked_joints(folder: Path, plan: Plan, table: dict[str, Any]) -> None:
    """Two films of one length, the same until the instant, then each on its own way to rest."""
    own, brake = stop_films(folder, 3.0, rate=10.0, after_end=0.2)
    assert [film.plan.scene.name for film in (own, brake)] == ["spill-free stop", "joints braked"]
    assert own.plan.certificate.ok and not brake.plan.certificate.ok
    assert own.end_time == pytest.approx(3.0 + table["stops"][0]["stops_in_s"])
    assert brake.end_time == pytest.approx(3.0 + table["controller"][0]["stops_in_s"])
    assert len(own.t) == len(brake.t) and own.length >= own.end_time + 0.2 - 1e-9
    np.testing.assert_allclose(own.joint_position[:31], brake.joint_position[:31], atol=1e-5)
    for film in (own, brake):
        np.testing.assert_allclose(film.joint_position[film.index(film.end_time) + 1], film.joint_position[-1])
    assert np.max(np.abs(own.joint_position[-1] - brake.joint_position[-1])) > 1e-3
    with pytest.raises(ScenarioError, match=r"--stop 2\.5 s: .* nearest is from 3 s"):
        stop_films(folder, 2.5, rate=10.0, after_end=0.2)
    (folder / "stops.json").write_text("{}", encoding="utf-8")
    with pytest.raises(PlanFolderError, match="damaged"):
        stop_films(folder, 3.0, rate=10.0, after_end=0.2)
