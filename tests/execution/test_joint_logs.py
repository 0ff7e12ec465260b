"""Joint logs as tables: columns by name, in any order and unit."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from nospill.errors import ScenarioError
from nospill.execution.csv_logs import read_table
from nospill.execution.log import JointLog, log_of_joints

JOINTS = ("joint_a", "joint_b")
ROWS = np.column_stack([np.linspace(0.0, 1.0, 30), np.linspace(0.1, 0.2, 30), np.linspace(-1.0, 1.0, 30)])


def write(place: Path, header: str, rows: np.ndarray = ROWS, separator: str = ",") -> Path:
    np.savetxt(place, rows, delimiter=separator, header=header, comments="")
    return place


def read(place: Path, **options: object) -> JointLog:
    offsets = options.pop("offsets", None)
    return log_of_joints(read_table(place, joints=2), JOINTS, offsets, **options)  # type: ignore[arg-type]


@pytest.mark.parametrize(
    ("header", "separator", "factor"),
    [
        ("t_s,joint_a_rad,joint_b_rad", ",", 1.0),
        ("time;joint_a [deg];joint_b [deg]", ";", np.pi / 180.0),
        ("timestamp actual_q_0 actual_q_1", " ", 1.0),
        ("T (s)\tQ1_deg\tQ2_deg", "\t", np.pi / 180.0),
        ("t,joint1,joint2", ",", 1.0),
        ("t,joint_a_position,joint_b_position", ",", 1.0),
    ],
)
def test_columns_are_found_by_name(tmp_path: Path, header: str, separator: str, factor: float) -> None:
    found = read(write(tmp_path / "log.csv", header, separator=separator))
    assert found.t == pytest.approx(ROWS[:, 0])
    assert found.position == pytest.approx(factor * ROWS[:, 1:])
    assert found.command is None


def test_columns_in_another_order_with_others_between(tmp_path: Path) -> None:
    rows = np.column_stack([ROWS[:, 2], np.full(30, 7.0), 1e3 * ROWS[:, 0], ROWS[:, 1]])
    found = read(write(tmp_path / "log.csv", "joint_b,current_1,t_ms,joint_a", rows))
    assert found.t == pytest.approx(ROWS[:, 0])
    assert found.position == pytest.approx(ROWS[:, 1:])


def test_a_recording_of_rtde_has_its_command(tmp_path: Path) -> None:
    rows = np.column_stack([ROWS, ROWS[:, 1:] + 0.01])
    found = read(write(tmp_path / "rtde.csv", "timestamp actual_q_0 actual_q_1 target_q_0 target_q_1", rows, " "))
    assert found.command == pytest.approx(ROWS[:, 1:] + 0.01)


def test_the_laboratorys_file_has_neither_header_nor_time(tmp_path: Path) -> None:
    np.savetxt(tmp_path / "robot.csv", ROWS[:, 1:], delimiter=";")
    assert read(tmp_path / "robot.csv").t == pytest.approx(np.arange(30) / 500.0)
    assert read(tmp_path / "robot.csv", rate=250.0).t == pytest.approx(np.arange(30) / 250.0)


def test_degrees_that_no_column_names(tmp_path: Path) -> None:
    found = read(write(tmp_path / "log.csv", "t,q1,q2"), unit="deg")
    assert found.position == pytest.approx(np.radians(ROWS[:, 1:]))


def test_another_zero_of_a_joint(tmp_path: Path) -> None:
    found = read(write(tmp_path / "log.csv", "t,q1,q2"), offsets={"joint_b": np.pi})
    assert found.position == pytest.approx(ROWS[:, 1:] + [0.0, np.pi])


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "is empty"),
        ("t,q1,q2,q3\n" + "0,1,2,3\n" * 30, "3 columns q1 to q3 where the robot has 2 joints.*another robot"),
        (
            "t,speed,current\n" + "0,1,2\n" * 30,
            r"no columns of the 2 joints joint_a, joint_b.*found: t, speed, current",
        ),
        ("t,q1,q2\n0,1,2\n0.1,1,2\n0.2,1", "row 4 has 2 values where 3 are needed; the file stops in the middle"),
        ("t,q1,q2\n0,1,2\n0.1,x,2\n", 'row 3: "x" in column q1 is not a number'),
        ("t,q1,q1\n" + "0,1,2\n" * 30, "two columns are named q1"),
        ("1;2;3\n" * 30, "3 columns without a header where the robot has 2 joints"),
        ("t,q1,q2\n0,1,2\n0.1,1,2\n", "2 rows; at least 20 are needed"),
        ("t,q1,q2\n" + "".join(f"{-k},1,2\n" for k in range(30)), "time runs backwards from 0 s to -1 s"),
    ],
)
def test_bad_tables_are_refused_in_one_line(tmp_path: Path, text: str, message: str) -> None:
    (tmp_path / "log.csv").write_text(text, encoding="utf-8")
    with pytest.raises(ScenarioError, match=message) as caught:
        read(tmp_path / "log.csv")
    assert "\n" not in str(caught.value)


def test_a_rate_beside_times_is_refused(tmp_path: Path) -> None:
    with pytest.raises(ScenarioError, match=r"--rate 100: .* has times of its own"):
        read(write(tmp_path / "log.csv", "t,q1,q2"), rate=100.0)


def test_an_offset_of_no_joint_is_refused(tmp_path: Path) -> None:
    with pytest.raises(ScenarioError, match="--offset q7: the robot has no such joint; choose joint_a or joint_b"):
        read(write(tmp_path / "log.csv", "t,q1,q2"), offsets={"q7": 1.0})
