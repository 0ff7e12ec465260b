"""slow: a plan of a lower speed, certified; what is refused."""

from __future__ import annotations

import json
from pathlib import Path

import pytest

from nospill.errors import NoSolutionError
from nospill.plans.loading import load_plan
from tests.cli.commands import nospill


def test_half_the_speed_is_on_the_same_way_and_certified(gentle_plan, tmp_path: Path) -> None:
    gentle_plan("pp-two-cups", 1).save(tmp_path / "fast")
    result = nospill("slow", str(tmp_path / "fast"), "--to", "50%")
    assert result.exit_code == 0, result.stderr
    assert "50 % of the speed; from the way of the plan at most 0." in result.stdout
    assert "another motion" not in result.stdout
    slower = load_plan(tmp_path / "fast-50-percent")
    assert slower.certificate.ok
    assert slower.duration == pytest.approx(2 * load_plan(tmp_path / "fast").duration, rel=5e-3)
    assert nospill("check", str(tmp_path / "fast-50-percent")).exit_code == 0


def test_where_no_motion_on_the_way_holds_the_other_is_named(gentle_plan, tmp_path: Path, monkeypatch) -> None:
    def none(planned, speed):
        raise NoSolutionError("on the way of this plan no motion holds")

    monkeypatch.setattr("nospill.planning.slower.slower", none)
    gentle_plan("pp-two-cups", 1).save(tmp_path / "fast")
    result = nospill("slow", str(tmp_path / "fast"), "--to", "50%")
    assert result.exit_code == 3
    assert "no motion holds; --another-way plans the gentlest motion that takes as long" in result.stderr
    assert not (tmp_path / "fast-50-percent").exists()


@pytest.mark.slow
@pytest.mark.usefixtures("every_other_speed")
def test_another_way_is_twice_the_duration_and_certified(gentle_plan, tmp_path: Path) -> None:
    plan = gentle_plan("pp-two-cups", 1)
    plan.save(tmp_path / "fast")
    result = nospill("slow", str(tmp_path / "fast"), "--to", "50%", "--another-way")
    assert result.exit_code == 0, result.stderr
    assert "50 % of the speed; from the way of the plan at most" in result.stdout
    slower = load_plan(tmp_path / "fast-50-percent")
    assert slower.certificate.ok
    assert slower.duration == pytest.approx(2 * load_plan(tmp_path / "fast").duration, rel=1e-3)
    stated = json.loads((tmp_path / "fast-50-percent" / "summary.json").read_text())
    assert stated["largest_use_at_lower_speeds"]["contact"] > 0.0
    assert len(stated["other_speeds"]) == 12


@pytest.mark.parametrize(
    ("speed", "says"), [("0", "must be above 0"), ("120%", "at most 100 %"), ("half", "give a plain number")]
)
def test_speeds_that_are_none(speed: str, says: str, tmp_path: Path) -> None:
    result = nospill("slow", str(tmp_path), "--to", speed)
    assert result.exit_code == 2
    assert says in result.stderr and result.stderr.count("\n") == 1
