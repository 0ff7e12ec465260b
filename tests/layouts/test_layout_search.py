"""Layouts: the optimum of a known law is found, and a real one is certified, apart, and no longer than as stated."""

from __future__ import annotations

from itertools import combinations
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from nospill.errors import NoSolutionError, ScenarioError
from nospill.layouts.record import Layout
from nospill.layouts.search import layout
from nospill.layouts.spacing import Spacing
from nospill.layouts.variables import variables_of
from nospill.planning import varied
from nospill.planning.planner import Planner
from nospill.planning.varied import Varied
from nospill.plans.plan import Plan
from nospill.scenario import load
from nospill.scenario.layout import layout_faults, overlap
from nospill.scene.scene import Scene
from tests.cli.commands import nospill

RADIUS = 0.035
"""m, of the cups of matrix-liquid."""


def law(scene: Scene) -> float:
    """A duration that is the shorter the nearer c1 and c2 are to the middle: least where they touch about it."""
    return 1.0 + sum(float(item.position @ item.position) for item in scene.cargo if item.name in ("c1", "c2"))


class Law:
    """In the planner's place; `wall`: x of c1 beyond which there is no motion."""

    wall = np.inf

    def __init__(self) -> None:
        self.last = 0.0

    def plan(self, scene: Scene) -> Any:
        if scene.cargo[0].position[0] > self.wall:
            raise NoSolutionError("No motion found: beyond the wall")
        self.last = law(scene)
        return SimpleNamespace(duration=self.last, certificate=SimpleNamespace(ok=True), scene=scene)

    def duration_change(self, scene: Scene) -> float:
        return law(scene) - self.last


def by_law(monkeypatch: pytest.MonkeyPatch, free: dict[str, Any], *, wall: float = np.inf, **options: Any) -> Layout:
    planner = type("OfTest", (Law,), {"wall": wall})
    monkeypatch.setattr(varied, "Planner", planner)
    pair = load("matrix-liquid").changed({"cargo.c3": None, "cargo.c4": None})
    return layout(pair, free, **options)


def test_two_that_seek_the_middle_end_touching_about_it(monkeypatch: pytest.MonkeyPatch) -> None:
    found = by_law(monkeypatch, {"cargo.*.at": None}, plans=60)
    first, second = (np.array(found.values[f"cargo.{name}.at"]) for name in ("c1", "c2"))
    assert found.plan.duration == pytest.approx(1.0 + 2 * RADIUS**2, rel=1e-4)
    assert np.linalg.norm(first - second) == pytest.approx(2 * RADIUS, rel=0.02)
    assert np.linalg.norm(first + second) < 0.02
    assert found.gained is not None and found.gained > 0.02
    assert len(found.tried) <= 60 and found.before is not None


def test_a_layout_without_a_motion_ends_no_search(monkeypatch: pytest.MonkeyPatch) -> None:
    found = by_law(monkeypatch, {"cargo.c1.at": None}, wall=-0.05, plans=60)
    assert any(trial.why_not.endswith("beyond the wall") for trial in found.tried)
    assert -0.055 <= found.values["cargo.c1.at"][0] <= -0.05
    assert found.plan.duration == min(trial.duration for trial in found.tried if trial.duration is not None)
    with pytest.raises(NoSolutionError, match=r"none of \d+ layouts has a certified motion; .*beyond the wall"):
        by_law(monkeypatch, {"cargo.c1.at": None}, wall=-1.0, plans=3)


def test_the_same_seed_is_the_same_search(monkeypatch: pytest.MonkeyPatch) -> None:
    found = [by_law(monkeypatch, {"cargo.*.at": None}, plans=20, seed=seed) for seed in (3, 3, 4)]
    assert found[0].tried == found[1].tried != found[2].tried
    assert all(trial.start == 0 for trial in by_law(monkeypatch, {"cargo.*.at": None}, plans=5).tried)


def test_a_real_layout_is_certified_apart_and_no_longer() -> None:
    scene = load("matrix-liquid")
    found = layout(scene, {"cargo.*.at": None, "tray.offset": ["80 mm", "130 mm"]}, plans=6)
    assert isinstance(found.plan, Plan)
    best = found.plan.scene
    assert found.plan.certificate.ok and found.before is not None and found.before.certificate.ok
    assert found.plan.duration <= found.before.duration
    assert not layout_faults(best.cargo, best.tray)
    assert all(overlap(first, second) <= 1e-9 for first, second in combinations(best.cargo, 2))
    assert scene.changed(found.values) == best
    assert best.source["tray"].get("offset", 0.1) >= 0.08 if isinstance(best.source["tray"]["offset"], float) else True


@pytest.fixture(scope="module")
def planned() -> Planner:
    """A planner that has just planned matrix-liquid; what it foretells changes nothing of it."""
    planner = Planner()
    planner.plan(load("matrix-liquid"))
    return planner


@pytest.mark.parametrize(
    "changes",
    [
        {"cargo.*.max_slosh_height": 0.0152},
        {"tray.friction": 0.472},
        {"cargo.c2.at": [0.0924, 0.06878]},
    ],
)
def test_the_multipliers_foretell_what_a_change_brings(changes: dict[str, Any], planned: Planner) -> None:
    scene = load("matrix-liquid")
    assert planned.last is not None and planned.duration_change(scene) == 0.0
    # objects do not feel how the tray is turned on the flange, and no joint is at a limit here
    assert planned.duration_change(scene.changed({"tray.rotation": [0.02, 0.0, 0.0]})) == pytest.approx(0.0, abs=1e-5)
    foretold = planned.duration_change(scene.changed(changes))
    # to the first order: twice the change is twice the time
    twice = {key: (2 * np.array(value) - np.array(_stated(scene, key))).tolist() for key, value in changes.items()}
    assert planned.duration_change(scene.changed(twice)) == pytest.approx(2 * foretold, rel=0.05)
    if "cargo.*.max_slosh_height" in changes:
        wider = 10 * (0.0152 - 0.015) / 0.015
        saved = {key.split(" | ")[0]: value for key, value in planned.last.report.savings.items()}
        assert -foretold == pytest.approx(wider * saved["slosh height"], rel=0.2)
    else:
        assert foretold != 0.0


def _stated(scene: Scene, key: str) -> Any:
    return {
        "cargo.*.max_slosh_height": 0.015,
        "tray.friction": 0.466308,
        "cargo.c2.at": [0.09216, 0.06878],
    }[key]


def test_nothing_planned_foretells_nothing(planned: Planner) -> None:
    scene = load("matrix-liquid")
    with pytest.raises(ScenarioError, match="nothing was planned before; call plan first"):
        Planner().duration_change(scene)
    with pytest.raises(ScenarioError, match="other objects, liquids or rules"):
        planned.duration_change(scene.changed({"motion.tilt": "free"}))


def test_distances_and_their_slopes_of_discs_are_those_of_geometry() -> None:
    scene = load("matrix-liquid")
    variables = variables_of(Varied(scene), {"cargo.c1.at": None})
    spacing = Spacing(Varied(scene), variables)
    at = np.array([0.01, -0.02])
    others = {item.name: item.position for item in scene.cargo if item.name != "c1"}
    expected = [np.linalg.norm(at - place) - 2 * RADIUS for place in others.values()]
    edge = np.min(scene.tray.size / 2 - np.abs(at)) - RADIUS
    np.testing.assert_allclose(spacing.distances(at), [edge, *expected], atol=1e-12)
    directions = [(at - place) / np.linalg.norm(at - place) for place in others.values()]
    np.testing.assert_allclose(spacing.slopes(at)[1:], directions, atol=1e-6)
    np.testing.assert_allclose(spacing.slopes(at)[0], [0.0, 1.0], atol=1e-6)


@pytest.mark.parametrize(
    ("free", "message"),
    [
        ({}, "a layout without anything that may change"),
        ({"tray.offset": None}, "tray.offset: needs a least and a greatest value"),
        ({"tray.offset": "100 mm"}, 'tray.offset: "100 mm" is no range; give [least, greatest]'),
        ({"tray.offset": ["150 mm", "80 mm"]}, "tray.offset: the least value 0.15 is above 0.08"),
        ({"tray.offset": ["1 mm", "2 mm"]}, "tray.offset: the scenario's own value is outside its range"),
        ({"tray.offset": [[0.0, 1.0], [1.0, 2.0]]}, "tray.offset: its range has 2 and 2 numbers, the scenario 1"),
        ({"tray.colour": [1, 2]}, "tray.colour: the scenario states no value there to start from"),
        ({"motion.tilt": ["fixed", "free"]}, 'motion.tilt: "fixed" is no number'),
        ({"cargo.c9.at": None}, "cargo.c9.at: the scenario states no value there"),
    ],
)
def test_ranges_that_are_none_are_refused_in_one_line(free: dict[str, Any], message: str) -> None:
    with pytest.raises(ScenarioError) as error:
        layout("matrix-liquid", free)
    assert message in str(error.value) and "\n" not in str(error.value)


def test_ends_of_a_free_path_stay() -> None:
    with pytest.raises(ScenarioError, match=r"path\.goal\.position: the ends of a free path are not moved"):
        layout("shelf-to-table", {"path.goal.position": [[0.0, 0.0, 0.0], [1.0, 1.0, 1.0]]})


def test_a_number_that_cannot_be_moved_is_named_and_one_that_touches_is_not(monkeypatch: pytest.MonkeyPatch) -> None:
    """A derivative that fails for another reason than touching is no zero in silence."""
    refuses = {"friction"}

    class Deaf(Law):
        def duration_change(self, scene: Scene) -> float:
            if refuses and scene.source["tray"]["friction"] != 0.466308:
                raise ScenarioError("the friction cannot be told")
            return super().duration_change(scene)

    monkeypatch.setitem(globals(), "Law", Deaf)
    free = {"cargo.*.at": None, "tray.friction": [0.4, 0.5]}
    assert by_law(monkeypatch, free, plans=40).stuck["tray.friction"] == "the friction cannot be told"
    refuses.clear()
    assert by_law(monkeypatch, free, plans=40).stuck == {}


def small(**tables: Any) -> dict[str, Any]:
    """A cup on a short line of a UR10e, with other tables."""
    cup = {"name": "cup", "at": [0.02, 0.0], "shape": "cylinder", "radius": "40 mm", "height": "95 mm"}
    cup |= {"liquid": "water", "liquid_height": "60 mm", "max_slosh_height": "8 mm", "empty_mass": "0.3 kg"}
    return {
        "name": "small",
        "fidelity": "deliverable",
        "robot": {"model": "ur10e"},
        "tray": {"size": ["300 mm", "300 mm"], "friction": 0.4, "mass": "0.5 kg", "offset": "50 mm"},
        "path": {"type": "line", "start": [0.6, -0.25, 0.5], "end": [0.6, 0.25, 0.5], "yaw": ["0 deg", "60 deg"]},
        "motion": {"end": "residual", "residual_fraction": 0.8},
        "planning": {"intervals": 20},
        "cargo": [cup],
    } | tables


RACK = [
    {"name": "cup", "shape": "box", "at": [0.0, 0.0], "length": 0.12, "width": 0.08, "height": 0.04, "mass": 0.25},
    {"name": "vial", "carrier": "cup", "at": [0.0, 0.0], "array": {"count": [2, 1], "pitch": ["60 mm", "60 mm"]}}
    | {"seat_height": "5 mm", "shape": "cylinder", "radius": "15 mm", "height": "60 mm", "liquid": "water"}
    | {"liquid_height": "30 mm", "max_slosh_height": "6 mm", "empty_mass": "10 g"},
]


@pytest.mark.parametrize(
    "tables",
    [
        {"tolerance": {"friction": "5 %", "position": "3 mm"}},  # of the level: test_largest_margin.py
        {"controller": {"interface": "ur-servoj", "compensate": True, "lag": "20 ms"}},
        {"motion": {"end": "residual", "residual_fraction": 0.8, "speed_range": ["97 %", "100 %"]}},
        {"cargo": RACK, "fidelity": "full"},
    ],
    ids=["tolerance", "controller", "speed range", "carrier"],
)
def test_whatever_a_plan_takes_a_layout_does(tables: dict[str, Any]) -> None:
    """The best layout is certified as its own plan is, with tolerances, controller, other speeds and carriers."""
    found = layout(small(**tables), {"cargo.cup.at": None}, plans=2)
    assert found.plan.certificate.ok and found.stuck == {}
    assert found.before is not None and found.plan.duration <= found.before.duration


def test_a_base_that_the_planner_turns_is_refused() -> None:
    with pytest.raises(ScenarioError, match=r"state an angle, and let robot\.base_yaw change"):
        layout(load("matrix-liquid").changed({"robot.base_yaw": "free"}), {"cargo.c1.at": None})


def test_a_stated_duration_is_refused() -> None:
    with pytest.raises(ScenarioError, match="takes as long in every layout"):
        layout(load("matrix-liquid").changed({"motion.duration": "3 s"}), {"cargo.c1.at": None})


def test_command_writes_plan_and_picture(tmp_path: Path) -> None:
    found = nospill("layout", "matrix-rigid", "--free", "cargo.*.at", "--plans", "2", "-o", str(tmp_path / "best"))
    assert found.exit_code == 0, found.stderr
    assert "certified" in found.stdout
    assert (tmp_path / "best" / "figures" / "layout.png").stat().st_size > 10_000
    assert nospill("check", str(tmp_path / "best")).exit_code == 0
    refused = nospill("layout", "matrix-rigid", "--free", "tray.offset")
    assert refused.exit_code == 2 and "tray.offset: needs a least and a greatest value" in refused.stderr
