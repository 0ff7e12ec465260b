"""Twenty modes of every liquid, written out a second time (`benchmarks.slosh.twenty_modes`), against the judge."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from benchmarks.slosh.twenty_modes import reached, tray_motion
from nospill.certification.after_end import free_heights, residual_height
from nospill.certification.certificate import Judgement, judge_motion
from nospill.certification.full_model import full_scene, with_full_model
from nospill.certification.verdict import Row
from nospill.certification.wording import full_model_note
from nospill.core.trees import flatten
from nospill.laws.scene_parameters import numbers_of, structure_of
from nospill.laws.slosh.residual import free_states
from nospill.planning.candidate import exported
from nospill.planning.log import Log
from nospill.planning.search import find_motion, passage_searches
from nospill.planning.task import Task
from nospill.plans.loading import load_plan
from nospill.plans.plan import Plan
from nospill.robots.joint_paths.search import joint_paths, preferred_path
from nospill.scenario import read_scenario
from nospill.scene.carriers import with_modes
from nospill.scene.scene import FULL_MODES
from tests.builders import with_linear_heights

HEIGHT, RESIDUAL = "slosh height", "residual height"
_ERROR = 1e-6
"""Of the integrator's steps: heights are within 1e-5 of those of steps a thousand times as exact."""


def row(judgement: Judgement, constraint: str, subject: str) -> Row:
    rows = (row for row in judgement.certificate.rows if (row.constraint, row.subject) == (constraint, subject))
    return next(rows)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "subject", "tilt"),
    [("mixed-tray", "box", (0.2, -0.15)), ("mixed-tray", "mug", (0.2, -0.15))],
)
def test_heights_of_a_smooth_motion(smooth_motion, name: str, subject: str, tilt: tuple[float, float]) -> None:
    motion = smooth_motion(name, stretch=0.9, tilt=tilt)
    scene = full_scene(motion.scene)
    judgement = judge_motion(motion.trajectory, scene)
    cargo = next(item for item in scene.cargo if item.name == subject)
    height, residual = reached(tray_motion(motion.trajectory), cargo, after=2.0, error=_ERROR)
    found, limit = row(judgement, HEIGHT, subject), row(judgement, RESIDUAL, subject).limit
    assert found.linear_value == pytest.approx(height, rel=2e-4)
    # A bound for all time; the paraboloid of the first mode, which swings on with it here, is left out there.
    assert residual <= row(judgement, RESIDUAL, subject).worst_value + 5e-3 * limit


@pytest.mark.slow
def test_a_certified_plan_keeps_its_limits_with_twenty_modes(example_plan) -> None:
    found = example_plan("mixed-tray")
    assert found.status == "certified" and found.judgement is not None
    tray = tray_motion(found.trajectory)
    for cargo in (item for item in found.scene.cargo if item.filling is not None):
        turning = 2 * FULL_MODES - 1 if cargo.shape == "box" else 0  # the tray tilts: yaw modes too
        assert found.trajectory.slosh[cargo.name].displacement.shape[1] == 2 * FULL_MODES + turning
        height, residual = reached(tray, cargo, after=1.0, error=_ERROR)
        for constraint, ours in ((HEIGHT, height), (RESIDUAL, residual)):
            judged = row(found.judgement, constraint, cargo.name)
            if constraint == HEIGHT:  # what is left is judged by the flow, which a box that turns leaves less of
                assert ours <= 1.005 * judged.limit
            assert ours <= (judged.linear_value or judged.worst_value) + 5e-3 * judged.limit
        assert height == pytest.approx(row(found.judgement, HEIGHT, cargo.name).linear_value, rel=5e-4)


@pytest.mark.slow
def test_what_one_mode_allows_twenty_refuse() -> None:
    """The fastest motion for one mode excites the others, which the optimiser did not see."""
    scene = with_linear_heights(full_scene(read_scenario("matrix-liquid-tilt")))
    scene = replace(scene, cargo=scene.cargo[:1])
    paths = joint_paths(scene.robot, scene.path, tool=scene.tray.tool)
    path = preferred_path(paths, scene.robot, scene.start_near)
    searches = passage_searches(Task.of(scene.with_one_mode()), path)
    trajectory = exported(find_motion(searches, Log(None, 300.0)))
    blind, seeing = (judge_motion(trajectory, item) for item in (scene.with_one_mode(), scene))
    names = (HEIGHT, RESIDUAL)
    assert all(row(blind, name, "c1").use < 1.003 for name in names)
    assert all(row(seeing, name, "c1").use > 1.03 for name in names) and not seeing.certificate.ok


def test_modes_are_those_the_scenario_states(changed_scene) -> None:
    counts = [
        structure_of(scene).objects[0].modes
        for scene in (
            read_scenario("matrix-liquid-tilt"),
            changed_scene("matrix-liquid-tilt", {"planning.slosh_modes": 3}),
            read_scenario("matrix-liquid"),
            changed_scene("matrix-liquid", {"planning.slosh_modes": 2}),
        )
    ]
    assert counts == [FULL_MODES, 3, 1, 2]


@pytest.mark.parametrize("index", [0, 2])
def test_residual_played_on_bounds_the_free_motion(index: int) -> None:
    """Of random ends: never below the highest surface of ten seconds, never above the sum of the modes' bounds."""
    scene = full_scene(read_scenario("mixed-tray"))
    item, numbers = structure_of(scene).objects[index], numbers_of(scene).objects[index]
    axes = [mode for mode, own in zip(numbers.oscillators, item.oscillators, strict=True) for _ in own]
    frequency, damping, gain = (
        np.array([getattr(mode, name) for mode in axes]) for name in ("frequency", "damping", "surface_gain")
    )
    random = np.random.default_rng(7)
    for _ in range(3):
        amplitude = 1e-3 / (1 + np.arange(len(axes)) // 2) ** 1.5
        q, qd = random.normal(size=(2, len(axes))) * amplitude
        value = residual_height(item, numbers, flatten(numbers), q, qd * frequency, 1e-4)
        later, _ = free_states(frequency, damping, q, qd * frequency, np.arange(0.0, 10.0, 1e-3))
        highest = free_heights(item, numbers, later).max()
        assert highest <= 1.003 * value
        assert value <= 1.1 * highest
        assert value <= 1.03 * np.sum(gain * np.hypot(np.abs(q), np.abs(qd) + damping * np.abs(q)))


def test_free_states_are_a_motion() -> None:
    """Rates are the derivative of displacements, and both start as given."""
    random = np.random.default_rng(2)
    frequency, damping = random.uniform(20, 120, 6), random.uniform(0, 0.3, 6)
    q, qd = random.normal(size=(2, 6)) * [[1e-3], [0.05]]
    t = np.arange(0.0, 0.2, 1e-5)
    displacement, rate = free_states(frequency, damping, q, qd, t)
    np.testing.assert_allclose(displacement[0], q, atol=1e-15)
    np.testing.assert_allclose(rate[0], qd, atol=1e-14)
    np.testing.assert_allclose(np.gradient(displacement, t, axis=0)[1:-1], rate[1:-1], atol=1e-6)


@pytest.mark.slow
def test_full_model_beside_a_published_certificate(smooth_motion: Callable) -> None:
    """The same rows as a verdict at full fidelity, which `ok` does not depend on."""
    motion = smooth_motion("matrix-liquid", cargo=2, stretch=0.6)
    judgement = judge_motion(motion.trajectory, motion.scene)
    certificate = with_full_model(judgement.certificate, motion.trajectory, motion.scene)
    assert certificate.published and certificate.ok == judgement.certificate.ok
    assert certificate.rows == judgement.certificate.rows
    assert certificate.full_model is not None
    assert {item.constraint for item in certificate.full_model} >= {HEIGHT}
    heights = [item for item in certificate.full_model if item.constraint == HEIGHT]
    for item in heights:
        cargo = next(own for own in full_scene(motion.scene).cargo if own.name == item.subject)
        height, _ = reached(tray_motion(motion.trajectory), cargo, after=0.01, error=_ERROR)
        assert item.worst_value == pytest.approx(height, rel=1e-3)
    worst = max(heights, key=lambda item: item.use)
    note = full_model_note(certificate)
    assert f'{1e3 * worst.worst_value:.3g} mm in "{worst.subject}"' in note and "over its limit" in note
    assert with_full_model(certificate, motion.trajectory, motion.scene) is certificate


def test_full_model_looks_at_solids_too(smooth_motion: Callable) -> None:
    """Slip and twist draw on the same friction there: without liquids too, a published plan may slide."""
    motion = smooth_motion("matrix-rigid", stretch=0.4)
    published = judge_motion(motion.trajectory, motion.scene).certificate
    full = judge_motion(motion.trajectory, full_scene(motion.scene)).certificate
    found = with_full_model(published, motion.trajectory, motion.scene).full_model
    contact = ("lift", "slip", "tip", "twist")
    assert found and found == tuple(row for row in full.rows if row.constraint in contact and not row.ok)
    assert "slips" in full_model_note(replace(published, full_model=found))
    assert with_full_model(full, motion.trajectory, full_scene(motion.scene)).full_model == ()


def test_twenty_modes_beside_a_certificate_with_one(smooth_motion: Callable) -> None:
    tilting = smooth_motion("mixed-tray", stretch=0.8)
    one = judge_motion(tilting.trajectory, tilting.scene).certificate
    assert full_model_note(one) == ""  # nobody has looked
    noted = with_full_model(one, tilting.trajectory, tilting.scene)
    assert noted.ok == one.ok and noted.full_model and "20 modes of each liquid see" in full_model_note(noted)
    assert with_full_model(one, tilting.trajectory, full_scene(tilting.scene)).full_model == ()


@pytest.mark.parametrize(
    ("name", "cargo", "modes", "expected"),
    [
        ("matrix-liquid", slice(1), 1, "certified as published"),
        ("mixed-tray", slice(1), 1, "certified with 1 mode"),
        ("mixed-tray", slice(1), 3, "certified with 3 modes"),
        ("mixed-tray", slice(1), FULL_MODES, "certified"),
        ("mixed-tray", slice(3, 4), 1, "certified"),  # the bottle: no liquid, no modes
    ],
)
def test_words_of_a_verdict(smooth_motion: Callable, name: str, cargo: slice, modes: int, expected: str) -> None:
    """Never "certified" alone of less than the full model, whatever that sees in the motion."""
    motion = smooth_motion(name, stretch=1.3)
    chosen = tuple(with_modes(item, modes) for item in motion.scene.cargo[cargo])
    scene = replace(motion.scene, cargo=chosen, slosh_modes=modes)
    certificate = judge_motion(motion.trajectory, scene).certificate
    assert certificate.ok and certificate.word == expected
    assert replace(certificate, full_model=()).word == expected
    assert replace(certificate, ok=False).word == "not certified"
    known = certificate.to_dict()
    assert (known["published"], known["modes"]) == (scene.fidelity == "deliverable", scene.fewer_modes)


def test_the_word_of_fewer_modes_is_kept_with_a_plan(gentle_plan: Callable[..., Plan], tmp_path: Path) -> None:
    found = gentle_plan("mixed-tray", 1)
    word = "certified with 1 mode"
    assert found.status == word and found.message.startswith(f"Certified with 1 mode: {found.duration:.3f} s")
    found.save(tmp_path / "plan")
    again = load_plan(tmp_path / "plan")
    assert again.certificate == found.certificate and again.status == again.summary()["status"] == word
