"""A stop and the controller's own, as films on one clock."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from nospill.errors import NospillError
from nospill.plans.loading import load_plan
from nospill.stopping.filmed import films_of_stop
from tests.cli.commands import nospill

AT = 0.4


@pytest.fixture(scope="module")
def folder(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A plan whose stops were found from a few instants."""
    place = tmp_path_factory.mktemp("stops") / "plan"
    assert nospill("plan", "pp-two-cups", "--no-figures", "-o", str(place)).exit_code == 0
    assert nospill("stops", str(place), "--every", "400ms").exit_code == 0
    return place


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["joints", "path"])
def test_both_are_the_plan_until_the_instant_and_stand_afterwards(folder: Path, kind: str) -> None:
    own, brake = films_of_stop(folder, f"{AT} s", kind, rate=100.0, after_end=0.1)
    plan, table = load_plan(folder), json.loads((folder / "stops.json").read_text())
    assert len(own.t) == len(brake.t) and own.plan.certificate.ok and not brake.plan.certificate.ok
    asked = plan.trajectory.motion(own.t)
    for film in (own, brake):
        before = film.t <= AT
        assert np.abs(film.joint_position - asked)[before].max() < 1e-4
        assert np.abs(film.joint_position[-1] - film.joint_position[-5]).max() < 1e-9
        assert np.abs(film.joint_position - asked)[-1].max() > 0.1
    [entry] = [item for item in table["stops"] if item["t_s"] == pytest.approx(AT)]
    assert own.end_time == pytest.approx(AT + entry["stops_in_s"], abs=0.02)
    assert brake.end_time < own.end_time
    crests = [max(float(track.height.max()) for track in film.liquids.values()) for film in (own, brake)]
    assert crests[1] > 1.5 * crests[0]


@pytest.mark.slow
def test_what_there_is_no_stop_for_is_refused_in_one_line(folder: Path, tmp_path: Path) -> None:
    for at, kind, said in [
        ("0.41 s", "joints", "no stop of .* begins then, the nearest one at 0.4 s"),
        ("0.4 m", "joints", "--stop: "),
        ("0.4 s", "power", "--beside .* is no stop of a controller; give joints"),
    ]:
        with pytest.raises(NospillError, match=said) as caught:
            films_of_stop(folder, at, kind, rate=25.0, after_end=0.1)
        assert "\n" not in str(caught.value)
    bare = tmp_path / "plan"
    bare.mkdir()
    for file in folder.iterdir():
        if file.is_file() and file.name != "stops.json":
            (bare / file.name).write_bytes(file.read_bytes())
    with pytest.raises(NospillError, match="no stops have been found of this plan; run nospill stops"):
        films_of_stop(bare, "0.4 s", "joints", rate=25.0, after_end=0.1)
