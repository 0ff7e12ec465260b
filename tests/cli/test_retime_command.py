"""retime: a file of joint positions becomes a plan; what is refused is one line."""

from __future__ import annotations

from pathlib import Path

import pytest

from nospill.plans.loading import load_plan
from tests.cli.commands import nospill

SCENARIO = """
[robot]
model = "ur5e"
[tray]
size = ["200 mm", "150 mm"]
friction = 0.5
offset = "80 mm"
[[cargo]]
name = "b"
shape = "box"
length = "60 mm"
width = "60 mm"
height = "60 mm"
mass = "0.2 kg"
at = [0, 0]
[path]
type = "line"
start = ["0.4 m", "-0.1 m", "0.4 m"]
end = ["0.4 m", "0.1 m", "0.4 m"]
[motion]
tilt = "free"
[planning]
intervals = 40
"""
HEADER = (
    "shoulder_pan_joint_deg,shoulder_lift_joint_deg,elbow_joint_deg,wrist_1_joint_deg,wrist_2_joint_deg,"
    "wrist_3_joint_deg,t_s\n"
)
POINTS = HEADER + "0,-80,92,78,-90,0,0\n20,-80,92,78,-90,10,0\n30,-70,90,70,-90,10,9\n"


@pytest.mark.slow
def test_a_file_becomes_a_plan_that_passes_its_points(tmp_path: Path) -> None:
    (tmp_path / "s.toml").write_text(SCENARIO)
    (tmp_path / "p.csv").write_text(POINTS)
    result = nospill(
        "retime", str(tmp_path / "p.csv"), "--scenario", str(tmp_path / "s.toml"), "-o", str(tmp_path / "d")
    )
    assert result.exit_code == 0, result.stderr
    assert "path: p.csv, 3 points; 1 other columns are not used: the timing is planned" in result.stderr
    assert "corners at point 2 are rounded, up to" in result.stderr
    plan = load_plan(tmp_path / "d")
    assert plan.certificate.ok and not plan.scene.motion.tilt_free
    assert nospill("check", str(tmp_path / "d")).exit_code == 0


@pytest.mark.parametrize(
    ("points", "says"),
    [
        ("1,2,3\n4,5,6\n", "3 columns without a header where the robot has 6 joints"),
        (POINTS.replace("_deg", ""), "at -80 rad, as if the points were in degrees"),
        (POINTS.replace("20,-80", "20,nan"), "p.csv: row 3: column shoulder_lift_joint has no finite number"),
    ],
)
def test_what_is_refused_is_one_line(points: str, says: str, tmp_path: Path) -> None:
    (tmp_path / "s.toml").write_text(SCENARIO)
    (tmp_path / "p.csv").write_text(points)
    result = nospill("retime", str(tmp_path / "p.csv"), "--scenario", str(tmp_path / "s.toml"))
    assert result.exit_code == 2
    assert says in result.stderr and result.stderr.count("\n") == 1
