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
        ("p.yml", 'joint_names: ["a", "b"]\npoints:\n- {"positions": [0, 1], "velocities": [9, 9]}\n- {"positions": [5e-1, 1.5]}'),  # noqa: E501
        ("p.json", json.dumps({"msg": {"joint_names": ["b", "a"], "points": [{"positions": [1, 0]}, {"positions": [1.5, 0.5]}]}})),  # noqa: E501
    ],
)  # fmt: skip
def test_files_that_are_read(name: str, text: str, tmp_path: Path) -> None:
    (tmp_path / name).write_text(text, encoding="utf-8")
    read = read_joint_points(tmp_path / name, JOINTS)
    np.testing.assert_allclose(read.points, POINTS, atol=1e-12)
    assert read.origin.startswith(f"{name}, 2 points")


@pytest.mark.parametrize(
    ("name", "text", "says"),
    [
        ("p.csv", "", "is empty"),
        ("p.csv", "a,c\n0,1\n", 'line 1: no column of joint "b"; the file has a, c, and the robot the joints a, b'),
        ("p.csv", "0,1,2\n", "3 columns without a header where the robot has 2 joints"),
        ("p.csv", "a,b\n0,1\n0\n", "line 3: 1 values where 2 are needed"),
        ("p.csv", "a,b\n0,nan\n", 'line 2: "nan" is not a finite number'),
        ("p.csv", "a,a,b\n0,0,1\n", 'column "a" stands there twice'),
        ("p.json", "{", "is not JSON"),
        ("p.json", "[1]", "holds no joint_names with points"),
        ("p.json", '{"joint_names": ["a", "x"], "points": [{"positions": [0, 1]}]}', 'no joint "b"; the trajectory has a, x'),  # noqa: E501
        ("p.json", '{"joint_names": ["a", "b"], "points": [{"positions": [0]}]}', "point 1 has 1 positions where 2"),
        ("p.yaml", "joint_names: [a, b]\npoints:\n- positions: [0, .nan]", 'point 1: ".nan" is not a finite number'),
    ],
)  # fmt: skip
def test_files_that_are_refused(name: str, text: str, says: str, tmp_path: Path) -> None:
    (tmp_path / name).write_text(text, encoding="utf-8")
    with pytest.raises(ScenarioError) as error:
        read_joint_points(tmp_path / name, JOINTS)
    assert says in str(error.value) and str(tmp_path / name) in str(error.value) and "\n" not in str(error.value)
