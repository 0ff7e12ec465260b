"""How far a number may go: found to its precision where the bound is known in closed form, and certified."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from nospill.errors import NoSolutionError, ScenarioError
from nospill.planning import varied
from nospill.planning.planner import plan
from nospill.plans.plan import Plan
from nospill.scenario import load
from nospill.scenario.settings import stated_value
from nospill.sweeps.bounds import Bound, largest
from tests.cli.commands import nospill

FRICTION = 0.466308


class Law:
    """In the planner's place: a duration of the friction, none above a bound; warm it may come out longer."""

    power = -0.5
    steepest = 10.0
    warm_excess = 0.0

    def __init__(self) -> None:
        self.warm = False

    def plan(self, scene: Any) -> Any:
        friction = scene.source["tray"]["friction"]
        if friction > self.steepest:
            raise NoSolutionError("No motion found: too steep")
        duration = friction**self.power * (1.0 + self.warm * self.warm_excess)
        self.warm = True
        return SimpleNamespace(duration=duration, certificate=SimpleNamespace(ok=True))


def search(monkeypatch: pytest.MonkeyPatch, within: float, **options: Any) -> Bound:
    law = type(
        "OfTest", (Law,), {key: options.pop(key) for key in ("power", "steepest", "warm_excess") if key in options}
    )
    monkeypatch.setattr(varied, "Planner", law)
    return largest("matrix-rigid", "tray.friction", within, **options)


@settings(max_examples=12)
@given(st.floats(0.05, 1.9), st.sampled_from([-1.0, -0.5, 0.5, 2.0]), st.sampled_from([0.1, 0.01, 0.002]))
def test_the_bound_of_a_known_law_is_found_to_its_precision(bound: float, power: float, precision: float) -> None:
    with pytest.MonkeyPatch.context() as patch:
        found = search(patch, bound**power, least=power < 0, power=power, precision=precision)
    assert found.value == pytest.approx(bound, rel=precision + 1e-3)  # values have four digits
    assert found.plan.duration <= found.within * (1 + 1e-9)
    assert found.beyond is not None and found.beyond.duration is not None
    assert found.beyond.duration > found.within
    assert (found.value > found.beyond.value) == (power < 0)
    assert [item.number for item in found.tried] == sorted(item.number for item in found.tried)


def test_slope_is_that_of_the_law(monkeypatch: pytest.MonkeyPatch) -> None:
    found = search(monkeypatch, 0.5**-0.5, least=True)
    assert found.slope == pytest.approx(-0.5 * found.value**-1.5, rel=0.03)


def test_what_has_no_motion_is_beyond_the_bound_with_its_reason(monkeypatch: pytest.MonkeyPatch) -> None:
    found = search(monkeypatch, 5.0, steepest=0.6)
    assert found.value == pytest.approx(0.6, rel=0.011)
    assert found.beyond is not None and found.beyond.why_not == "No motion found: too steep"
    assert "does not do: No motion found: too steep" in found.text


def test_a_warm_plan_that_is_too_long_is_planned_from_nothing_before_it_counts(monkeypatch: pytest.MonkeyPatch) -> None:
    plain = search(monkeypatch, 0.3**-0.5, least=True)
    found = search(monkeypatch, 0.3**-0.5, least=True, warm_excess=0.01)
    # 1 % of the duration is 2 % of the friction; what is left of it is one step
    assert found.value == pytest.approx(plain.value, rel=0.011)


def test_where_nothing_ends_the_search_it_says_so(monkeypatch: pytest.MonkeyPatch) -> None:
    found = search(monkeypatch, 100.0, between=(0.2, 0.9))
    assert (found.value, found.beyond) == (0.9, None)
    assert str(found) == found.text
    assert found.text.endswith("the search ended there")


def test_no_value_is_no_solution_that_names_the_nearest(monkeypatch: pytest.MonkeyPatch) -> None:
    with pytest.raises(NoSolutionError, match=r"within 0.1 s; the nearest, 1\.\d+: 0\.\d{3} s"):
        search(monkeypatch, 0.1, least=True)


@pytest.mark.parametrize(
    ("key", "within", "options", "says"),
    [
        ("tray.frction", 2.0, {}, 'did you mean "friction"'),
        ("tray.frction", 2.0, {"between": (0.2, 0.4)}, 'unknown key "frction"; did you mean "friction"'),
        ("motion.tilt", 2.0, {}, "numbers of one unit are needed"),
        ("tray.size", 2.0, {"between": ("1 m", "2 kg")}, "numbers of one unit are needed"),
        ("cargo.c9.mass", 2.0, {}, "states no value there"),
        ("tray.friction", "2 m", {}, "is a length, not a time"),
        ("tray.friction", 0.0, {}, "give one above 0"),
        ("tray.friction", 2.0, {"precision": 0.0}, "precision 0 is out of range"),
    ],
)
def test_what_cannot_be_searched_is_one_line(key: str, within: Any, options: dict[str, Any], says: str) -> None:
    with pytest.raises(ScenarioError, match=says) as caught:
        largest("matrix-rigid", key, within, **options)
    assert "\n" not in str(caught.value)


def test_values_are_found_by_name_number_and_for_all() -> None:
    table = load("matrix-liquid").source
    assert stated_value(table, "cargo.c2.max_slosh_height") == "15 mm"
    assert stated_value(table, "cargo.0.max_slosh_height") == stated_value(table, "cargo.*.max_slosh_height")


def test_command_prints_the_trade_off_and_the_answer(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(varied, "Planner", Law)
    result = nospill(
        "largest", "tray.friction", "matrix-rigid", "--least", "--within", "1.5 s", "--between", "0.3", "0.5"
    )
    assert result.exit_code == 0, result.stderr
    assert "least tray.friction within 1.5 s: 0.4" in result.stdout and "too long" in result.stdout
    assert "ms for each 0.01" in result.stdout
    result = nospill("largest", "tray.frction", "matrix-rigid", "--within", "1.5 s")
    assert result.exit_code == 2 and result.stderr.splitlines()[-1].startswith("tray.frction: ")


@pytest.mark.slow
def test_the_answer_is_certified_and_the_next_value_planned_alone_is_too_long() -> None:
    found = largest("matrix-rigid", "tray.friction", plan("matrix-rigid").duration * 1.05, least=True, precision=0.05)
    assert isinstance(found.plan, Plan) and found.plan.certificate.ok and found.plan.duration <= found.within
    assert found.plan.scene.source["tray"]["friction"] == found.value < FRICTION
    assert found.beyond is not None
    beyond = plan(load("matrix-rigid").changed({"tray.friction": found.beyond.value}))
    assert beyond.duration > found.within * (1 - 2e-3)
