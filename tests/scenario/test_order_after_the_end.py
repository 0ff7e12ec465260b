"""To which order heights after the end are judged where the scenario does not say it."""

from __future__ import annotations

import pytest

from nospill.certification.height_order import height_note
from nospill.scenario import read_scenario

_SWING = {"displacement": [["1 mm", "0 mm"]], "velocity": [["0 m/s", "0 m/s"]]}
_SECOND = {**_SWING, "second_height": ["0 mm"], "second_velocity": ["0 m/s"]}


@pytest.mark.parametrize("name", ["matrix-liquid-tilt", "pp-two-cups"])
def test_the_flow_judges_upright_cups_by_default(name: str) -> None:
    assert read_scenario(name).changed({"fidelity": "full"}).motion.residual_height == "nonlinear"


@pytest.mark.parametrize(
    ("changes", "reason"),
    [
        ({"fidelity": "deliverable"}, ""),
        ({"motion.slosh_height": "linear"}, ""),
        ({"motion.speed_range": ["50 %", "100 %"]}, ""),
        ({"motion.speed_range": ["50 %", "100 %"], "motion.slosh_height": "second order"}, "motion.speed_range has"),
        ({"tolerance.tracking": {"delay": "3 ms"}}, "tolerance.tracking is a band of arms"),
        ({"cargo.c2.tolerance": {"frequency": "1 %"}}, '"c2" has a range of frequencies'),
        ({"cargo.c2.initial_swing": _SECOND}, '"c2" swings when the motion begins'),
        ({"planning.slosh_modes": 3}, "planning.slosh_modes leaves modes out"),
        ({"motion.residual_height": "linear"}, "motion.residual_height says so"),
    ],
)
def test_it_is_linear_where_the_flow_does_not_follow_all_that_is_known(changes: dict[str, object], reason: str) -> None:
    """What it does not know of a single liquid would be of second order, and kept by far smoother motions of all."""
    scene = read_scenario("matrix-liquid-tilt").changed(changes)
    assert scene.motion.residual_height == "linear"
    note = height_note(scene)
    own = [item for item in note.split("; ") if item.startswith("residual height: linear, since ")]
    assert all(reason in item for item in own) and len(own) == bool(reason)


@pytest.mark.parametrize(
    "changes",
    [
        {"cargo.c2.tolerance": {"liquid_height": "1 mm"}},
        {"controller": {"delay": "3 ms", "lag": "2 ms"}},
        {"motion.slosh_height": "nonlinear"},
        {"cargo.c2.contact_line": "free"},
        {"cargo.c2.initial_swing": _SWING},  # of the first order alone: linear in itself
    ],
)
def test_other_tolerances_a_known_controller_and_liquids_without_second_order_leave_it(
    changes: dict[str, object],
) -> None:
    assert read_scenario("matrix-liquid-tilt").changed(changes).motion.residual_height == "nonlinear"


@pytest.mark.parametrize("name", ["soup-and-wine", "vial-rack", "matrix-rigid"])
def test_without_a_liquid_that_the_flow_follows_it_is_linear(name: str) -> None:
    assert read_scenario(name).changed({"fidelity": "full"}).motion.residual_height == "linear"
