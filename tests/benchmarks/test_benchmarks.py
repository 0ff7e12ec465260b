"""The laws of the benchmark are those of the package at any point: a baseline of another problem measures nothing."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import casadi as ca
import numpy as np
import pytest

from benchmarks.planning import baseline, measurements, report, rows, scenes
from nospill.core.frames import SX
from nospill.core.trees import constants
from nospill.laws.like_objects import hull_objects
from nospill.laws.sample import object_motion, sample_objects, split_states
from nospill.laws.scene_parameters import numbers_of, structure_of
from nospill.laws.slosh.motion import modal_acceleration
from nospill.robots.kinematics.forward import kinematics
from nospill.scenario import read_scenario
from nospill.scenario.examples import EXAMPLES
from nospill.scene.scene import Scene
from nospill.transcription.path_expression import PathPiece, path_table, piece_degree, span_of
from nospill.transcription.tray_state import TrayState, tray_state

POINTS = [np.random.default_rng(seed).uniform(-1, 1, 32) for seed in range(4)]


@pytest.fixture(scope="module")
def liquid() -> Scene:
    return read_scenario("matrix-liquid")


@pytest.fixture(scope="module")
def rigid() -> Scene:
    return read_scenario("matrix-rigid")


def numbers(*expressions: SX) -> list[np.ndarray]:
    """Values of expressions without symbols."""
    function = ca.Function("values", [], [ca.densify(SX(expression)) for expression in expressions])
    return [np.array(value) for value in function.call([])]


def tray(scene: Scene, *chains: np.ndarray) -> TrayState:
    """The package's tray at given s and tilt chains."""
    state = tuple((SX(float(chain[0])), SX(float(chain[1])), SX(float(chain[2]))) for chain in chains)
    table = path_table(scene.path.breaks, scene.path.coefficients, degree=piece_degree(structure_of(scene)))
    piece = PathPiece.of(SX(ca.DM(table[:, span_of(scene.path.breaks, chains[0][:1])])))
    return tray_state(piece, state, freedom=structure_of(scene).freedom, gravity=SX(scene.gravity))


def waiter_rows(scene: Scene, state: TrayState, slosh: Any) -> np.ndarray:
    """Lift, slip, tip and twist of all objects from the package's wrench."""
    values = constants(numbers_of(scene))
    rows = []
    for item, cargo in zip(sample_objects(structure_of(scene), values, state.motion, slosh), scene.cargo, strict=True):
        force, moment = numbers(item.wrench.force, item.wrench.moment)
        press, tangential = force[2, 0], float(force[0, 0] ** 2 + force[1, 0] ** 2)
        hold = 2 / 3 * cargo.planned_friction * 0.035 * press
        tip = 0.035 / cargo.total.centre[2]
        rows += [press, (cargo.planned_friction * press) ** 2 - tangential, (tip * press) ** 2 - tangential]
        rows += [hold - moment[2, 0], hold + moment[2, 0]]
    return np.array(rows)


def s_chain(point: np.ndarray) -> np.ndarray:
    """A random s, s', s''."""
    return np.array([0.5 + 0.45 * point[0], 0.7 * point[1], 2 * point[2]])


@pytest.mark.parametrize("point", POINTS)
def test_path_of_the_baseline_is_the_bundled_one(liquid: Scene, point: np.ndarray) -> None:
    s = 0.5 + 0.5 * point[0]
    np.testing.assert_allclose(np.array(baseline.path_function()(s)).ravel(), liquid.path.at(s)[0], atol=1e-12)


@pytest.mark.parametrize("point", POINTS)
def test_level_rows_agree_with_the_package(liquid: Scene, point: np.ndarray) -> None:
    chain, slosh = s_chain(point), 0.01 * point[3:19]
    waiter, heights, joints, speeds = baseline.level_rows(liquid)(np.concatenate([chain, slosh]))
    state = tray(liquid, chain)
    still = split_states(structure_of(liquid), SX.zeros(8), SX.zeros(8), SX.zeros(8))
    np.testing.assert_allclose(np.array(waiter).ravel(), waiter_rows(liquid, state, still), atol=1e-11)
    gain = liquid.cargo[0].filling.modes.oscillators[0].surface_gain  # type: ignore[union-attr]
    displacement = slosh.reshape(4, 4)[:, :2]
    np.testing.assert_allclose(np.array(heights).ravel(), gain**2 * np.sum(displacement**2, axis=1), atol=1e-14)
    # The joint table is a cubic spline through 101 samples; between them it stays within a few hundredths of a mrad.
    arm, tool = kinematics(liquid.robot), liquid.tray.tool
    q, qd = np.array(joints).T, np.array(speeds).T
    position, velocity = numbers(state.position, state.velocity)
    motion = arm.motions(q, qd, np.zeros((1, 6)), tool=tool)
    np.testing.assert_allclose(motion.position[0], position.ravel(), atol=1e-4)
    np.testing.assert_allclose(motion.velocity[0], velocity.ravel(), atol=1e-2)


@pytest.mark.parametrize("point", POINTS)
def test_sloshing_agrees_with_the_package_in_turning_axes(liquid: Scene, point: np.ndarray) -> None:
    chain, q, qd = s_chain(point), 0.01 * point[3:5], 0.2 * point[5:7]
    state = np.zeros(19)
    state[:3], state[3:5], state[5:7] = chain, q, qd
    found = np.array(baseline.level_rate(liquid)(state, 0.0)).ravel()[5:7]

    values, structure = constants(numbers_of(liquid)), structure_of(liquid)
    yaw, spin, turn = np.pi * chain
    cross = np.array([[0.0, -1.0], [1.0, 0.0]])
    back = np.array([[np.cos(yaw), np.sin(yaw)], [-np.sin(yaw), np.cos(yaw)]])
    own = back @ q
    own_rate = back @ qd - spin * cross @ own
    motion = object_motion(values.objects[0], tray(liquid, chain).motion)
    acceleration = modal_acceleration(
        values.objects[0].oscillators[0],
        structure.objects[0].oscillators[0],
        motion,
        SX(ca.DM(own)),
        SX(ca.DM(own_rate)),
        damp_against_spin=True,
    )
    (change,) = numbers(acceleration)
    expected = back.T @ (change.ravel() + 2 * spin * cross @ own_rate + turn * cross @ own - spin**2 * own)
    np.testing.assert_allclose(found, expected, atol=1e-9)


@pytest.mark.parametrize("point", POINTS)
def test_tilting_rows_agree_with_the_package(rigid: Scene, point: np.ndarray) -> None:
    chain, tilt_x, tilt_y = s_chain(point), 0.3 * point[3:6], 0.3 * point[6:9]
    waiter, joints, speeds = baseline.tilting_rows(rigid)(np.concatenate([chain, tilt_x, tilt_y]))
    state = tray(rigid, chain, tilt_x, tilt_y)
    none = split_states(structure_of(rigid), SX.zeros(0), SX.zeros(0), SX.zeros(0))
    np.testing.assert_allclose(np.array(waiter).ravel(), waiter_rows(rigid, state, none), atol=1e-10)

    arm, tool = kinematics(rigid.robot), rigid.tray.tool
    motion = arm.motions(np.array(joints).T, np.array(speeds).T, np.zeros((1, 6)), tool=tool)
    position, rotation, velocity = numbers(state.position, state.rotation, state.velocity)
    omega = rotation @ numbers(state.motion.angular_velocity)[0].ravel()
    np.testing.assert_allclose(motion.position[0], position.ravel(), atol=1e-9)
    np.testing.assert_allclose(motion.rotation[0], rotation, atol=1e-9)
    np.testing.assert_allclose(motion.velocity[0], velocity.ravel(), atol=1e-8)
    np.testing.assert_allclose(motion.angular_velocity[0], omega, atol=1e-8)


def test_runge_kutta_is_of_fourth_order() -> None:
    x, u = ca.MX.sym("x", 2), ca.MX.sym("u")
    step = baseline.runge_kutta(ca.Function("rate", [x, u], [ca.vertcat(x[1], -x[0] + u)]), 2, 1)

    def error(count: int) -> float:
        state = ca.DM([1.0, 0.0])
        for _ in range(count):
            state = step(state, 0.0, 1.0 / count)
        return abs(float(state[0]) - np.cos(1.0))

    assert 14 < error(10) / error(20) < 18


@pytest.mark.parametrize("change", scenes.CHANGES)
def test_changed_scenes_keep_the_structure_and_nothing_else(liquid: Scene, change: str) -> None:
    other = scenes.changed("matrix-liquid", change)
    assert structure_of(other) == structure_of(liquid)
    assert repr(numbers_of(other)) != repr(numbers_of(liquid))


def test_trays_of_cups_fit_their_cups() -> None:
    for count in (1, 4, 32):
        assert len(scenes.tray_of_cups(count).cargo) == count


def test_no_like_cups_stand_for_different_ones() -> None:
    scene = scenes.different_cups(64)
    assert len(hull_objects(scene)) == 64


@pytest.mark.slow
def test_unseen_structures_are_none_of_the_examples() -> None:
    known = {structure_of(scenes.example(name)) for name in EXAMPLES}
    for name in scenes.UNSEEN:
        assert structure_of(scenes.unseen(name)) not in known


def test_grid_of_an_example_can_be_set() -> None:
    assert scenes.example("matrix-rigid", intervals=50).planning.intervals == 50


def test_targets_are_judged_in_their_direction() -> None:
    assert rows.Line("a", [1.0], ratio=70.0, target=60.0, most=False).verdict == "met"
    assert rows.Line("a", [1.0], ratio=50.0, target=60.0, most=False).verdict == "missed"
    assert rows.Line("a", [1.0], ratio=0.4, target=0.5).verdict == "met"
    assert rows.Line("a", [1.0]).verdict == ""


def test_lines_have_the_median_and_nearly_the_longest_run_of_clock_and_processor() -> None:
    line = rows.Line("a", [1.0, 2.0, 3.0], [0.5], ratio=0.5, of="of b", target=0.25)
    assert line.cells == ["a", "2.000", "2.960", "0.500", "", "0.5", "of b", "≤ 0.25", "missed"]


def measured(*seconds: float, **figures: Any) -> dict[str, Any]:
    """A measurement of some runs, the processor half as long as the clock."""
    runs = {"all_seconds": list(seconds), "all_processor": [0.5 * one for one in seconds]}
    return runs | {"seconds": seconds[0], "run": "today"} | figures


def test_table_skips_what_was_not_measured(tmp_path: Path) -> None:
    stated = {"processor": "p", "cores": 2, "load_before": 0.0, "load_after": 0.0, "python": "3", "casadi": "3"}
    results = {
        "machine": stated | {"commit": "abc", "changed_since": False},
        "measurements": {
            "baseline liquid": measured(75.0, iterations=500),
            "one mode: cold matrix-liquid": measured(0.5, certified=True, peak_memory_mb=150.0),
            "toppra, rigid on a level tray": {"missing": "No module named 'toppra'"},
        },
    }
    page = tmp_path / "page.md"
    page.write_text(f"before\n{report.BEGIN}\nyesterday\n{report.END}\nafter\n")
    report.write_page(results, page)
    printed = page.read_text()
    assert printed.startswith("before") and printed.endswith("after\n") and "yesterday" not in printed
    assert "whole physics" not in printed
    assert (
        "| one mode: cold matrix-liquid | 0.500 |  | 0.250 |  | 150 | times faster than baseline liquid | ≥ 100 | met |"
    ) in printed
    assert "not measured: toppra" in printed


def test_changed_scenes_are_compared_with_the_cold_plan_of_the_example() -> None:
    changes = {change: measured(1.0, 1.2, warm=change != "friction") for change in scenes.CHANGES}
    found = rows.Found({"cold mixed-tray": measured(4.0, duration=2.0), "warm mixed-tray": {"changes": changes}})
    cold, warm = rows.whole(found)
    assert (cold.ratio, cold.verdict) == (2.0, "missed")
    assert (warm.what, warm.ratio, warm.verdict) == (
        "changed mixed-tray (1 planned anew)",
        pytest.approx(0.275),
        "missed",
    )
    assert len(warm.clock) == len(warm.processor) == 8


def test_a_baseline_that_did_not_converge_is_compared_with_nothing() -> None:
    baseline = measured(95.0, iterations=700, status="Maximum_Iterations_Exceeded")
    found = rows.Found({"baseline liquid": baseline, "one mode: cold matrix-liquid": measured(0.5)})
    first, cold = rows.published(found)
    assert first.what.endswith("(700 iterations, not converged)")
    assert (cold.ratio, cold.verdict) == (None, "")


@pytest.mark.parametrize("name", measurements.WHOLE_EXAMPLES)
def test_a_change_of_an_example_with_the_whole_physics_changes_numbers_alone(name: str) -> None:
    stated = scenes.whole_example(name)
    assert (stated.fidelity, stated.slosh_modes) == ("full", 20) and stated.motion.slosh_height != "linear"
    for change in scenes.CHANGES:
        other = scenes.whole_changed(name, change)
        assert structure_of(other) == structure_of(stated), change
        assert repr(numbers_of(other)) != repr(numbers_of(stated)), change


def test_pyramids_lie_inside_the_cones(rigid: Scene) -> None:
    toppra_waiter = pytest.importorskip("benchmarks.planning.toppra_waiter", reason="toppra is not installed")
    normals, limits = toppra_waiter.cones(rigid)
    random = np.random.default_rng(3)
    for sample in random.uniform(-6, 6, (200, 16)):
        sample[2::4] += 9.81
        if np.all(normals @ sample <= limits):
            for index, cargo in enumerate(rigid.cargo):
                own = sample[4 * index : 4 * index + 4]
                assert np.hypot(own[0], own[1]) <= cargo.planned_friction * own[2]
