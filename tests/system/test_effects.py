"""Every constraint has an effect: left out of the plan, its own row of the certificate fails.

Most have it on the mixed tray with one cup and the bottle: one object of each kind is what the constraints tell apart.
Some are implied by others there and get a variant of the same tray, or are left out together with what implies them;
`implied_by` says by what:

* twist, by slip: slip at full fidelity counts the moment over the grip radius, which is smaller than the twist radius;
  only a load beside the middle of its footprint turns before it slides, and only when sliding is not looked at.
* lift, by slip, tip and twist: no friction and no footprint holds without pressing force. The path of the tray runs
  level, so nothing is ever lifted; the variant drops it.
* apparent gravity, by slip, on the way of the tray; in a drop only lift stands behind it.
* joint position: the arc lies far inside; the variant has a shoulder that reaches less far.
* tilt: two objects ask for less than the tray may tilt; the variant has a tighter limit.
* path jerk: the weights alone keep it below a tenth of its limit; the variant has a tighter one.
* corridor, and the jerks of what leaves the path: on a variant whose tray may leave it, with tighter limits of jerk.
* still at the end: asked for by another end condition than the tray's.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache

import pytest

from nospill.certification.verdict import Row
from nospill.errors import ScenarioError
from nospill.laws.constraints import CONSTRAINTS
from nospill.planning.planner import plan
from nospill.scenario import read_scenario
from nospill.scene.scene import Scene

pytestmark = pytest.mark.slow

_QUICK = {
    "planning.intervals": 30,
    "planning.starts": 1,
    "planning.slosh_modes": 1,
    "motion.slosh_height": "linear",  # the optimiser's law, so that each limit is met closely
}
_DROP = {
    "path": {"type": "line", "start": [0.8, 0.0, 1.45], "end": [0.8, 0.0, 1.0]},
    "motion.tilt": "fixed",
    "planning.path_jerk_weight": 1e-7,
}
_BESIDE = {
    "path.corridor": "30 mm",
    "path.yaw": ["0 deg", "free", "180 deg"],
}
_TIN = {
    "name": "tin",
    "at": ["80 mm", "60 mm"],
    "shape": "cylinder",
    "radius": "30 mm",
    "height": "40 mm",
    "mass": "0.4 kg",
    "centre_of_mass": ["22 mm", 0.0, "15 mm"],
}


@dataclass(frozen=True)
class Case:
    """A constraint, the variant of the mixed tray it is seen on, and what else has to be left out to see it."""

    constraint: str
    variant: str = "tray"
    implied_by: frozenset[str] = frozenset()


CASES = (
    Case("slosh height"),
    Case("trough", "shallow water"),
    Case("residual height"),
    Case("still at the end", "published end"),
    Case("apparent gravity", "drop of cup and bottle"),
    Case("lift", "drop of the bottle", frozenset({"slip", "tip", "twist"})),
    Case("slip"),
    Case("tip"),
    Case("twist", "tin loaded on one side", frozenset({"slip"})),
    Case("joint position", "short shoulder"),
    Case("joint speed"),
    Case("tilt", "tight tilt"),
    Case("path jerk", "tight path jerk"),
    Case("tilt jerk"),
    Case("corridor", "beside its path"),
    Case("offset jerk", "sharp steps aside"),
    Case("yaw jerk", "sharp turns"),
)


@pytest.fixture(scope="module")
def variant(changed_scene: Callable[..., Scene]) -> Callable[[str], Scene]:
    @cache
    def make(name: str) -> Scene:
        changes = {
            "published end": {"motion.end": "published"},
            "tight tilt": {"motion.max_tilt": "15 deg"},
            "shallow water": {"cargo.0.liquid_height": "10 mm", "cargo.0.max_slosh_height": "30 mm"},
            "tight path jerk": {"motion.path_jerk_limit": 25.0},
            "beside its path": _BESIDE,
            "sharp steps aside": _BESIDE | {"motion.path_jerk_limit": 30.0},
            "sharp turns": _BESIDE | {"motion.tilt_jerk_limit": 25.0},
            "drop of cup and bottle": _DROP,
            "drop of the bottle": _DROP,
        }
        cup, *_, bottle = read_scenario("mixed-tray").source["cargo"]
        alone = ("drop of the bottle", "tight tilt", "tight path jerk")  # of the tray
        alone += ("beside its path", "sharp turns")
        objects = {"tin loaded on one side": [cup, _TIN]} | {key: [bottle] for key in alone}
        scene = changed_scene(
            "mixed-tray", {"cargo": objects.get(name, [cup, bottle])} | _QUICK | changes.get(name, {})
        )
        if name == "short shoulder":
            upper = scene.robot.upper.copy()
            upper[1] = -0.07
            return scene.changed({"robot.limits.upper": upper})
        return scene

    return make


@pytest.fixture(scope="module")
def rows(variant: Callable[[str], Scene]) -> Callable[[str, frozenset[str]], tuple[Row, ...]]:
    """Certificate of a variant planned without some constraints, each planned once."""

    @cache
    def make(name: str, ignored: frozenset[str]) -> tuple[Row, ...]:
        return plan(variant(name), ignore=ignored).certificate.rows

    return make


def own(rows: tuple[Row, ...], constraint: str) -> list[Row]:
    found = [row for row in rows if row.constraint == constraint]
    assert found
    return found


def test_every_constraint_is_here() -> None:
    # Limits of joint acceleration, jerk and torque: tests/system/test_any_arm.py; of the tray's speed and
    # acceleration: tests/planning/test_tray_limits_reached.py; places to pass: tests/planning/test_via_and_region.py.
    elsewhere = {"joint acceleration", "joint jerk", "joint torque", "tray speed", "tray acceleration", "via"}
    assert {case.constraint for case in CASES} == {constraint.name for constraint in CONSTRAINTS} - elsewhere


@pytest.mark.parametrize("name", sorted({case.variant for case in CASES}))
def test_with_every_constraint_the_plan_is_certified(name: str, rows: Callable[..., tuple[Row, ...]]) -> None:
    assert [row for row in rows(name, frozenset()) if not row.ok] == []


@pytest.mark.parametrize("case", [pytest.param(case, id=case.constraint) for case in CASES])
def test_a_constraint_left_out_is_broken(case: Case, rows: Callable[..., tuple[Row, ...]]) -> None:
    kept = own(rows(case.variant, case.implied_by), case.constraint)
    assert all(row.ok for row in kept), "it does not hold by itself"
    # It stands at its limit while it is kept (a bound that is zero is met exactly), and far beyond when left out.
    if case.constraint != "still at the end":
        assert max(row.use for row in kept) > 0.95
    left_out = own(rows(case.variant, case.implied_by | {case.constraint}), case.constraint)
    assert max(row.use for row in left_out) > 1.01


def test_a_name_that_is_no_constraint(variant: Callable[[str], Scene]) -> None:
    with pytest.raises(ScenarioError, match=r'^ignore: "slosh" is no constraint; there are: slosh height, '):
        plan(variant("tray"), ignore={"slosh"})


def test_the_judge_leaves_out_nothing(rows: Callable[..., tuple[Row, ...]]) -> None:
    whole, less = rows("tray", frozenset()), rows("tray", frozenset({"tilt"}))
    assert [(row.constraint, row.subject) for row in whole] == [(row.constraint, row.subject) for row in less]
