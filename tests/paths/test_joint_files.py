"""Files of joint points: order, units and messages; refusals that name file and line."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from nospill.errors import ScenarioError
from nospill.paths.joint_files import read_joint_points

JOINTS = ("a", "b")
POINTS = [[0.0, 1.0], [0.5, 1.5]]
ECHO = """header:
  frame_id: ''
joint_names:
- b
- a
points:
- positions:
  - 1.0
  - 0.0
  velocities: []
  time_from_start:
    sec: 0
- positions:
  - 1.5
  - 0.5
---
"""


@pytest.mark.parametrize(
    ("name", "text"),
    [
        ("p.csv", "0,1\n0.5,1.5\n"),
        ("p.csv", "t_s,b,a\n0,1,0\n0,1.5,0.5\n"),
        ("p.csv", "# by hand\nb_deg; a [rad]; a_rad_s\n57.29577951308232;0;7\n\n85.94366926962348;0.5;7"),
        ("p.csv", "\ufeffq1 q2\r\n0 1\r\n0.5 1.5\r\n"),
        ("p.yaml", ECHO),
        ("p.yml", 'joint_names: ["a", "b"]\npoints:\n- {"positions": [0, 1]}\n- {"positions": [5e-1, 1.5]}'),
        ("p.json", json.dumps({"msg": {"joint_names": ["b", "a"], "points": [{"positions": [1, 0]}, {"positions": [1.5, 0.5]}]}})),  # noqa: E501
    ],
)  # fmt: skip
def test_files_that_are_read(name: str, text: str, tmp_path: Path) -> None:
    (tmp_path / name).write_text(text, encoding="utf-8")
    read = read_joint_points(tmp_path / name, JOINTS)
    np.testing.assert_allclose(read.points, POINTS, atol=1e-12)
    assert read.origin.startswith(f"{name}, 2 points")


def test_two_trajectories_in_one_file_are_not_one_path(tmp_path: Path) -> None:
    (tmp_path / "p.yaml").write_text(2 * ECHO, encoding="utf-8")
    with pytest.raises(ScenarioError, match="it holds 2 of them"):
        read_joint_points(tmp_path / "p.yaml", JOINTS)


def test_arrays_by_name(tmp_path: Path) -> None:
    np.savez(tmp_path / "p.npz", position=np.array(POINTS)[:, ::-1], joint_names=["ns/b", "ns/a"])
    np.testing.assert_array_equal(read_joint_points(tmp_path / "p.npz", JOINTS).points, POINTS)


@pytest.mark.parametrize(
    ("name", "text", "says"),
    [
        ("p.csv", "", "is empty"),
        ("p.csv", "a,c\n0,1\n", "no columns of the 2 joints a, b; columns with these names, or q1 to q2 in"),
        ("p.csv", "0,1,2\n", "3 columns without a header where the robot has 2 joints"),
        ("p.csv", "a,b\n0,1\n0\n", "row 3 has 1 values where 2 are needed"),
        ("p.csv", "a,b\n0,nan\n", "row 2: column b has no finite number"),
        ("p.csv", "a,a,b\n0,0,1\n", "two columns are named a"),
        ("p.json", "{", "is not JSON"),
        ("p.json", "[1]", "it holds none with points"),
        ("p.json", '{"joint_names": ["a", "x"], "points": [{"positions": [0, 1]}]}', 'its joints are a, x; "b" of the robot'),  # noqa: E501
        ("p.json", '{"joint_names": ["a", "b"], "points": [{"positions": [0]}]}', "point 1, positions: [0] is no list of 2"),  # noqa: E501
        ("p.yaml", "joint_names: [a, b]\npoints:\n- positions: [0, .nan]", "point 1 has a position that is not finite"),
    ],
)  # fmt: skip
def test_files_that_are_refused(name: str, text: str, says: str, tmp_path: Path) -> None:
    (tmp_path / name).write_text(text, encoding="utf-8")
    with pytest.raises(ScenarioError) as error:
        read_joint_points(tmp_path / name, JOINTS)
    assert says in str(error.value) and str(tmp_path / name) in str(error.value) and "\n" not in str(error.value)
