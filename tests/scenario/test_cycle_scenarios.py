"""Scenarios of cycles: what each leg carries and where it begins, and what is refused."""

from __future__ import annotations

import copy
import tomllib
from pathlib import Path
from typing import Any

import numpy as np
import pytest

import nospill as ns
from nospill.errors import ScenarioError
from nospill.scenario.examples import CYCLES, example_path
from nospill.scenario.settings import changed_table
from tests.cycles import there_and_back


def carried(cycle: ns.Cycle) -> list[list[str]]:
    return [[item.name for item in leg.scene.cargo] for leg in cycle.legs]


def test_a_leg_carries_what_is_left_and_begins_where_the_last_one_ends() -> None:
    cycle = ns.load_cycle(there_and_back())
    assert carried(cycle) == [["near", "far"], ["near"]]
    assert [leg.dwell for leg in cycle.legs] == [0.3, 0.2]
    assert [leg.scene.motion.hold_after for leg in cycle.legs] == [0.3, 0.2]
    ends = [leg.scene.path.at([0.0, 1.0]) for leg in cycle.legs]
    np.testing.assert_allclose(ends[1], ends[0][::-1], atol=1e-12)


def test_a_path_without_yaw_keeps_the_yaw_and_the_last_one_turns_back() -> None:
    turned = there_and_back()
    turned["leg"][0]["path"] |= {"yaw": ["20 deg", "-70 deg"]}
    legs = ns.load_cycle(turned).legs
    np.testing.assert_allclose(legs[1].scene.path.at([0.0, 1.0])[:, 3], np.radians([-70.0, 20.0]))


def test_what_is_put_on_first_is_not_there_at_first() -> None:
    table = there_and_back(
        out={"unload": ["near", "far"], "load": ["far"]}, back={"unload": ["*"], "load": ["near", "far"]}
    )
    assert carried(ns.load_cycle(table)) == [["near", "far"], ["far"]]
    late = there_and_back(out={"unload": ["near"], "load": ["far"]}, back={"unload": ["far"]})
    assert carried(ns.load_cycle(late)) == [["near"], ["far"]]


def test_members_of_an_array_are_taken_off_one_by_one() -> None:
    table = there_and_back(out={"unload": ["far-2-1"]})
    table["cargo"][0] |= {"at": [-0.1, 0.09]}
    table["cargo"][1] |= {"at": [0.05, 0.0], "array": {"count": [2, 1], "pitch": ["100 mm", "100 mm"]}}
    names = carried(ns.load_cycle(table))
    assert "far-2-1" in names[0] and set(names[0]) - set(names[1]) == {"far-2-1"}


def test_the_text_is_the_cycle_and_needs_no_other_file() -> None:
    for source in (there_and_back(), "bar-service", "matrix-cycle"):
        cycle = ns.load_cycle(source)
        again = ns.load_cycle(tomllib.loads(cycle.text))
        assert [leg.scene for leg in again.legs] == [leg.scene for leg in cycle.legs]
        assert again.text == cycle.text


@pytest.mark.parametrize("name", CYCLES)
def test_the_bundled_cycles_are_read_by_name_as_from_their_files(name: str) -> None:
    assert ns.load_cycle(name) == ns.load_cycle(example_path(name))


def test_every_file_of_a_cycle_has_its_line() -> None:
    assert sorted(file.stem for file in example_path("bar-service").parent.glob("*.toml")) == sorted(CYCLES)


BAD: list[tuple[dict[str, Any], str]] = [
    ({"leg.1.path.start": [0.6, 0.2, 0.5]}, r'leg "back": leg "back" begins 50 mm and 0 deg from where leg "out" ends'),
    ({"leg.1.path.end": [0.6, -0.2, 0.5]}, r'leg "out" begins 50 mm and 0 deg from where leg "back" ends'),
    ({"leg.1.path.yaw": ["9 deg", "9 deg"]}, r'leg "back": leg "back" begins 0 mm and 9 deg from where'),
    ({"leg.1.unload": ["far"]}, r'leg "back": unload: "far" is not on the tray then; leg "out" unloads it'),
    ({"leg.1.unload": ["fat"]}, r'there is no object "fat"; did you mean "far"\?'),
    ({"leg.1.unload": ["near", "near"]}, r'unload names "near" twice'),
    ({"leg.0.load": ["far"], "leg.1.load": ["far"]}, r'leg "back": load: "far" is on the tray already'),
    ({"leg.0.dwell": -0.1}, r'leg "out": dwell -0.1 is out of range'),
    ({"leg.0.dwell": "soon"}, r'dwell "soon" is not a time.*the word "shortest" is possible too'),
    ({"leg.0.lod": ["near"]}, r'leg "out": unknown key "lod"; did you mean "load"\?'),
    ({"leg.1.name": "out"}, r'leg 2: name "out" is already taken'),
    ({"leg.1.path": None}, r'leg "back": path is missing'),
    ({"leg.1.path.type": "lien"}, r'leg "back": \[path\] has the unknown type "lien"'),
    ({"leg.1.motion": {"tlt": "free"}}, r'leg "back": \[motion\]: unknown key "tlt"'),
    ({"leg.1.motion": {"speed_range": [0.5, 1.0]}}, r'leg "back": motion.speed_range in a cycle: a swing that goes on'),
    ({"motion.speed_range": [0.5, 1.0]}, r"motion.speed_range in a cycle"),
    ({"motion.hold_after": 1.0}, r"motion.hold_after in a cycle: how long the arm stands is the dwell of a leg"),
    ({"motion.stop": True}, r"motion.stop in a cycle"),
    ({"path": {"type": "line"}}, r"path in a cycle: every leg has its own"),
    ({"approach": {"from": "home"}}, r"approach in a cycle"),
    ({"initial_state": {}}, r"initial_state in a cycle"),
    ({"robot.base_yaw": "free"}, r'base_yaw = "free" in a cycle'),
    (
        {"leg.1.path": {"type": "free", "start": {"position": [0.5, 0.2, 0.4], "yaw": "free"}}},
        r'leg "back": path.start.yaw = "free" in a cycle: the place between two legs is known before',
    ),
    ({"cargo.near.initial_swing": {"displacement": [[0, 0]]}}, r'cargo "near": initial_swing in a cycle'),
    ({"leg": [{"name": "out"}]}, r"1 \[\[leg\]\] tables; a cycle has 2 to 50"),
    ({"leg": {"name": "out"}}, r"write \[\[leg\]\], with two brackets"),
    ({"leg": None}, r"has no \[\[leg\]\] tables"),
    ({"leg.0.load": ["new"]}, r'there is no object "new"; there are near and far'),
]


@pytest.mark.parametrize(("changes", "message"), BAD, ids=[message[:40] for _, message in BAD])
def test_what_cannot_mean_anything_is_refused_in_one_line(changes: dict[str, Any], message: str) -> None:
    with pytest.raises(ScenarioError, match=message) as caught:
        ns.load_cycle(changed_table(copy.deepcopy(there_and_back()), changes))
    assert caught.value.exit_code == 2 and len(str(caught.value).splitlines()) == 1


def test_what_stays_on_at_the_end_and_was_not_there_at_first_is_refused() -> None:
    late = there_and_back(out={"unload": ["near"], "load": ["far"]})
    with pytest.raises(ScenarioError, match="far would be on the tray when the cycle begins again"):
        ns.load_cycle(late)


def test_one_motion_is_meant_elsewhere(tmp_path: Path) -> None:
    with pytest.raises(ScenarioError, match=r"has \[\[leg\]\] tables: it is a cycle, for .*ns.load_cycle"):
        ns.load("bar-service")
    with pytest.raises(ScenarioError, match=r"matrix-liquid: has no \[\[leg\]\] tables: it is one motion"):
        ns.load_cycle("matrix-liquid")
