"""Histories against the rows of the certificate, contact loads against rigid bodies, modes against their rates."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest

from nospill.certification.certificate import Judgement, judge
from nospill.certification.histories import contact_load, history_of, modal_states
from nospill.certification.run import COMMAND
from nospill.core.frames import rotation_z
from nospill.errors import ScenarioError
from nospill.laws.constraints.base import RowId
from nospill.laws.constraints.clearance import Clearance
from nospill.scene.cargo import Cargo
from nospill.scene.controller import Controller
from nospill.scene.scene import Scene

CONTROLLED = "matrix-liquid through a controller, with holds"


@pytest.fixture(scope="module")
def judged(smooth_motion: Callable[..., object]) -> Callable[[str], tuple[Scene, Judgement]]:
    """A scene and the judgement of a smooth motion in it."""

    def make(name: str) -> tuple[Scene, Judgement]:
        motion = smooth_motion(name.split(" ")[0], tilt=(0.05, 0.02))
        scene: Scene = motion.scene  # type: ignore[attr-defined]
        if name == CONTROLLED:
            controller = Controller(np.full(6, 0.008), np.full(6, 0.015), compensate=True)
            rules = replace(scene.motion, hold_before=0.1, hold_after=0.05)
            scene = replace(scene, controller=controller, motion=rules)
        return scene, judge(motion.trajectory, scene)  # type: ignore[attr-defined]

    return make


@pytest.mark.parametrize(
    "name",
    [
        "mixed-tray",
        "matrix-rigid",
        "matrix-liquid-still",
        "matrix-liquid-corridor",
        "matrix-liquid-tilt-all-limits",
        "matrix-liquid-tilt-robust",
        "vial-rack",
        CONTROLLED,
    ],
)
def test_the_worst_instant_of_every_history_is_the_row(judged, name: str) -> None:
    scene, judgement = judged(name)
    for row in judgement.certificate.rows:
        found = history_of(judgement, scene, row.id)
        worst = int(np.argmax(found.use))
        assert (found.constraint, found.subject, found.unit) == (row.constraint, row.subject, row.unit)
        assert found.use[worst] == row.use and found.t[worst] == row.at_s and found.variant == row.variant
        columns = found.demand, found.limit, found.margin
        assert [column[worst] for column in columns] == [row.worst_value, row.limit, row.worst_margin]
        assert {len(found.t)} == {len(column) for column in (*columns, found.use)}
        assert np.all(np.diff(found.t) >= 0.0)


def test_histories_are_of_the_worst_variant_and_of_the_command(judged) -> None:
    scene, judgement = judged("matrix-liquid-tilt-robust")
    variants = {history_of(judgement, scene, row.id).variant for row in judgement.certificate.rows}
    assert len(variants) > 2 and "" in variants
    scene, judgement = judged(CONTROLLED)
    found = history_of(judgement, scene, RowId("joint speed", "joint_1"))
    assert found.variant == COMMAND and found.t[0] < 0.0
    assert found.demand[0] == pytest.approx(0.0, abs=1e-6)


def test_the_history_of_a_distance_has_the_least_one(judged) -> None:
    scene, judgement = judged("cups-past-a-column")
    rows = [row for row in judgement.certificate.rows if row.constraint == Clearance.name]
    assert len(rows) > 20
    for row in rows:
        found = history_of(judgement, scene, row.id)
        assert row.at_s in found.t
        # A distance is a bound that holds between the samples too, at most 0.1 mm below the least one.
        assert np.min(found.demand) == pytest.approx(row.worst_value, abs=1e-4)
        np.testing.assert_allclose(found.margin, found.demand - found.limit)


@pytest.mark.parametrize("name", ["mixed-tray", "matrix-rigid"])
def test_the_contact_of_a_solid_is_its_mass_times_its_specific_force(judged, name: str) -> None:
    """Newton and Euler in base axes, from the motion of the tray; as published, only the spin has an inertia."""
    scene, judgement = judged(name)
    cargo = next(item for item in scene.cargo if not item.filling)
    found, tray = contact_load(judgement, scene, cargo.name), judgement.replay.tray
    turn = tray.rotation @ np.array(rotation_z(cargo.yaw))
    arm, centre = tray.rotation @ np.append(cargo.position, cargo.seat), turn @ cargo.empty.centre
    omega, alpha = tray.angular_velocity, tray.angular_acceleration
    r = arm + centre
    acceleration = tray.acceleration + np.cross(alpha, r) + np.cross(omega, np.cross(omega, r))
    force = cargo.empty.mass * (acceleration + np.array([0.0, 0.0, scene.gravity]))
    np.testing.assert_allclose(_turned(turn, found.force), force, atol=1e-9)
    assert np.all(found.force[:, 2] > 0.0), "pressing is positive"
    if scene.fidelity == "full":
        inertia = turn @ cargo.empty.inertia @ np.swapaxes(turn, 1, 2)
        spin = _turned(inertia, alpha) + np.cross(omega, _turned(inertia, omega))
        np.testing.assert_allclose(_turned(turn, found.moment), np.cross(centre, force) + spin, atol=1e-9)


def _turned(matrices: np.ndarray, vectors: np.ndarray) -> np.ndarray:
    return np.einsum("mij,mj->mi", matrices, vectors)


@pytest.mark.parametrize("name", ["mixed-tray", "vial-rack"])
def test_the_contact_presses_as_the_row_of_lift_says(judged, name: str) -> None:
    scene, judgement = judged(name)
    standing: list[Cargo] = [cargo for cargo in scene.cargo if not cargo.carrier]
    for cargo in standing:
        force = contact_load(judgement, scene, cargo.name).force[:, 2]
        lift = history_of(judgement, scene, RowId("lift", cargo.name))
        grid = np.isin(lift.t, judgement.replay.t)
        np.testing.assert_allclose(force / force[0], lift.demand[grid] / lift.demand[0], rtol=1e-9)


def test_modes_begin_as_stated_and_are_the_integrals_of_their_rates(judged) -> None:
    scene, judgement = judged("mixed-tray")
    for cargo in scene.cargo:
        if cargo.filling is None:
            continue
        found = modal_states(judgement, scene, cargo.name)
        assert found.displacement.shape == found.velocity.shape == (len(found.t), found.displacement.shape[1])
        assert np.all(found.displacement[0] == 0.0) and np.max(np.abs(found.displacement)) > 1e-4
        step = float(found.t[1] - found.t[0])
        risen = np.diff(found.displacement, axis=0) / step
        np.testing.assert_allclose(risen, (found.velocity[1:] + found.velocity[:-1]) / 2, atol=2e-4)


def history(constraint: str, subject: str) -> Callable[..., object]:
    return lambda judgement, scene: history_of(judgement, scene, RowId(constraint, subject))


def contact(name: str) -> Callable[..., object]:
    return lambda judgement, scene: contact_load(judgement, scene, name)


def modes(name: str) -> Callable[..., object]:
    return lambda judgement, scene: modal_states(judgement, scene, name)


@pytest.mark.parametrize(
    ("ask", "message"),
    [
        (history("slosh heigt", "cup"), "no history 'slosh heigt': did you mean 'slosh height'? there are "),
        (history("slosh height", "cupp"), "of 'cupp': did you mean 'cup'? there are cup, mug, box"),
        (history("approach slip", "cup"), "'approach slip' is judged on the way to the start"),
        (contact("vase"), "no object 'vase'; there are cup, mug, box, bottle"),
        (modes("mugg"), "no object 'mugg': did you mean 'mug'? there are cup, mug, box"),
        (modes("bottle"), "'bottle' holds no liquid; there are liquids in cup, mug, box"),
    ],
)
def test_what_there_is_not_is_refused_with_what_there_is(judged, ask: Callable[..., object], message: str) -> None:
    scene, judgement = judged("mixed-tray")
    with pytest.raises(ScenarioError) as caught:
        ask(judgement, scene)
    assert message in str(caught.value) and "\n" not in str(caught.value)


def test_what_stands_in_a_carrier_touches_no_tray(judged) -> None:
    scene, judgement = judged("vial-rack")
    vial = next(cargo for cargo in scene.cargo if cargo.carrier)
    with pytest.raises(ScenarioError, match=f"'{vial.name}' moves with '{vial.carrier}', in which it stands"):
        contact_load(judgement, scene, vial.name)
