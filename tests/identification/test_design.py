"""The most informative test motion for fill, damping, delay and lag."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from typer.testing import CliRunner

import nospill as ns
from nospill.cli import app
from nospill.errors import ScenarioError
from nospill.identification import design
from nospill.identification.design import Design, Records, optimal_experiment
from nospill.identification.design import experiment_scene as scene_of_the_test
from nospill.identification.liquid_fit import fit_liquid
from nospill.identification.liquid_law import LiquidLaw
from nospill.scene.scene import Scene
from nospill.simulation.motion_file import Heights

RECORDS = Records(rest=6.0)


@pytest.fixture(scope="module")
def scene() -> Scene:
    whole = scene_of_the_test(ns.load("matrix-liquid"))
    return replace(whole, cargo=whole.cargo[:1])


@pytest.fixture(scope="module")
def found(scene: Scene) -> Design:
    """Of a small family."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(design, "RAMPS", (3,))
        patch.setattr(design, "SLOWEST", 1.6)
        return optimal_experiment(scene, RECORDS)


@pytest.mark.slow
def test_it_is_certified_and_swings_on(found: Design) -> None:
    assert found.plan.certificate.ok
    assert found.plan.maxima.residual_height["c1"] > 5e-3
    assert found.tried > 1


@pytest.mark.slow
def test_what_is_expected_is_what_a_fit_finds(found: Design, scene: Scene) -> None:
    motion, end = found.plan.trajectory.motion, found.plan.duration
    law = LiquidLaw(motion, scene, 0.0, end + RECORDS.rest)
    t = np.arange(0.0, end + RECORDS.rest, 1.0 / RECORDS.rate)
    noise = RECORDS.height_noise * np.random.default_rng(1).standard_normal(len(t))
    seen = Heights(t, law.with_slopes(0.0, 0.0, t)[0] + noise)
    fit = fit_liquid(motion, scene, "c1", seen, begin=0.0, end=end)
    for own in found.expected[:2]:
        assert fit.of(own.name).half_width == pytest.approx(own.half_width, rel=0.4)
        assert abs(fit.of(own.name).value - own.value) < 1.5 * own.half_width


@pytest.mark.slow
def test_joints_that_move_are_expected_to_be_told(found: Design) -> None:
    joints = [own for own in found.expected if own.name in ("delay", "lag")]
    assert {own.subject for own in joints} >= {"joint_1", "joint_6"}
    assert all(own.identifiable for own in joints)


def test_the_scene_of_the_test_lets_liquids_swing_on_a_level_tray() -> None:
    own = scene_of_the_test(ns.load("matrix-liquid-tilt"))
    assert not own.motion.tilt_free
    assert own.motion.residual_fraction == 1.0


def test_a_tray_without_liquids_is_refused() -> None:
    with pytest.raises(ScenarioError, match="nothing holds a liquid"):
        optimal_experiment(scene_of_the_test(ns.load("matrix-rigid")))


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--rest", "0 s"], "--rest 0 s: must be above zero"),
        (["--noise", "1"], "--noise: "),
        (["--rate", "1"], "--rate 1: 5 to 10000 are allowed"),
    ],
)
def test_bad_input_is_one_line_and_exit_code_2(arguments: list[str], message: str) -> None:
    result = CliRunner().invoke(app, ["design-test", "matrix-liquid", *arguments])
    assert result.exit_code == 2, result.output
    assert message in result.output
    assert len(result.output.strip().splitlines()) == 1
