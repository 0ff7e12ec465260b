"""The exported trajectory: file and back to the bit, damaged files in one line, end time, the motion."""

from __future__ import annotations

from dataclasses import fields, replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from nospill.errors import PlanFolderError, ScenarioError
from nospill.motion.trajectory import SloshTrack, Trajectory, read_trajectory, trajectory_text

SINGLE = ("t", "s", "s_rate", "s_acceleration")
WIDE = {
    "tilt": 2,
    "tilt_rate": 2,
    "tilt_acceleration": 2,
    "joint_position": 3,
    "joint_speed": 3,
    "joint_acceleration": 3,
    "tray_position": 3,
    "tray_quaternion": 4,
}


def trajectory_of(values: np.ndarray) -> Trajectory:
    """A record filled column by column from a table of 34 columns."""
    columns = iter(values.T)

    def block(count: int) -> np.ndarray:
        return np.column_stack([next(columns) for _ in range(count)])

    single: dict[str, Any] = {name: next(columns) for name in SINGLE}
    wide: dict[str, Any] = {name: block(count) for name, count in WIDE.items()}
    return Trajectory(
        **single,
        joints=("shoulder", "elbow_rad", "theta"),
        **wide,
        slosh={
            "cup": SloshTrack(block(2), block(2), next(columns)),
            "cup_slosh": SloshTrack(block(1), block(1), next(columns)),
        },
    )


def random_trajectory(rows: int = 20) -> Trajectory:
    return trajectory_of(np.random.default_rng(1).normal(size=(rows, 34)))


def same(first: Trajectory, second: Trajectory) -> bool:
    if first.joints != second.joints or list(first.slosh) != list(second.slosh):
        return False
    pairs = [(getattr(first, name), getattr(second, name)) for name in (*SINGLE, *WIDE)]
    for name, track in first.slosh.items():
        other = second.slosh[name]
        pairs += [(getattr(track, field.name), getattr(other, field.name)) for field in fields(track)]
    return all(np.array_equal(a, b) and a.shape == b.shape for a, b in pairs)


@settings(deadline=None, max_examples=30)
@given(
    values=hnp.arrays(
        float, st.tuples(st.integers(10, 14), st.just(34)), elements=st.floats(allow_nan=False, allow_infinity=False)
    )
)
def test_file_and_back_is_exact(tmp_path_factory, values):
    path = tmp_path_factory.mktemp("trajectory") / "trajectory.csv"
    trajectory = trajectory_of(values)
    path.write_text(trajectory_text(trajectory))
    assert same(read_trajectory(path), trajectory)


def test_planned_trajectory_and_back(smooth_motion, tmp_path):
    trajectory = smooth_motion("mixed-tray", tilt=(0.1, 0.1)).trajectory
    (tmp_path / "trajectory.csv").write_text(trajectory_text(trajectory))
    assert same(read_trajectory(tmp_path / "trajectory.csv"), trajectory)


def test_solids_have_no_slosh_columns(smooth_motion, tmp_path):
    trajectory = smooth_motion("matrix-rigid").trajectory
    text = trajectory_text(trajectory)
    assert "slosh" not in text and "height" not in text
    (tmp_path / "trajectory.csv").write_text(text)
    assert same(read_trajectory(tmp_path / "trajectory.csv"), trajectory)


def test_header_names_units():
    header = trajectory_text(random_trajectory()).splitlines()[0].split(",")
    assert header[:4] == ["t_s", "s", "s_rate_1_s", "s_acceleration_1_s2"]
    assert header[4:10] == [
        "theta_x_rad",
        "theta_y_rad",
        "theta_x_rate_rad_s",
        "theta_y_rate_rad_s",
        "theta_x_acceleration_rad_s2",
        "theta_y_acceleration_rad_s2",
    ]
    assert header[10:13] == ["shoulder_rad", "elbow_rad_rad", "theta_rad"]
    assert header[-3:] == ["cup_slosh_slosh_1_m", "cup_slosh_slosh_rate_1_m_s", "cup_slosh_height_m"]
    assert len(set(header)) == len(header)


def damaged(tmp_path: Path, change) -> Path:
    path = tmp_path / "trajectory.csv"
    lines = trajectory_text(random_trajectory()).splitlines()
    result = change(lines)
    path.write_text("\n".join(lines if result is None else result) + "\n")
    return path


def set_line(index: int, text: str):
    def change(lines: list[str]) -> None:
        lines[index] = text

    return change


def set_cell(row: int, column: int, text: str):
    def change(lines: list[str]) -> None:
        cells = lines[row].split(",")
        cells[column] = text
        lines[row] = ",".join(cells)

    return change


@pytest.mark.parametrize(
    "change",
    [
        lambda lines: [f"\ufeff{lines[0]}", *lines[1:]],
        lambda lines: [*lines, "", "  "],
        lambda lines: [line.replace(",", ", ") for line in lines],
    ],
    ids=["byte order mark", "blank last lines", "spaces after commas"],
)
def test_what_other_programs_leave_in_a_file_is_read(tmp_path, change):
    path = damaged(tmp_path, change)
    assert same(read_trajectory(path), random_trajectory())


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (set_cell(7, 5, "1_0"), "line 8, column theta_y_rad: '1_0' is not a number"),
        (set_cell(7, 5, "\uff11"), "line 8, column theta_y_rad: '\uff11' is not a number"),
        (lambda lines: [], "not a trajectory of nospill: column t_s is missing"),
        (set_line(0, "a,b,c"), "column t_s is missing"),
        (set_cell(0, 1, "progress"), "column s is missing"),
        (set_cell(0, 4, "theta_z_rad"), "column theta_x_rad is missing"),
        (lambda lines: [",".join(reversed(lines[0].split(","))), *lines[1:]], "not a trajectory of nospill"),
        (lambda lines: [lines[0] + ",extra", *lines[1:]], "not in the order"),
        (lambda lines: lines[:6], r"5 rows below the header, at least 10 are needed"),
        (lambda lines: lines[:1], r"0 rows below the header"),
        (set_cell(7, 5, "many"), "line 8, column theta_y_rad: 'many' is not a number"),
        (set_cell(7, 0, ""), "line 8, column t_s: '' is not a number"),
        (set_line(7, "1,2,3"), "line 8 has 3 values, the header 34"),
        (set_line(7, ""), "line 8 has 1 values, the header 34"),
        (set_cell(7, 5, "nan"), "line 8, column theta_y_rad: nan is not a finite number"),
        (set_cell(20, 0, "-inf"), "line 21, column t_s: -inf is not a finite number"),
        (lambda lines: [line + ",1" if index else line for index, line in enumerate(lines)], "line 2 has 35 values"),
    ],
)
def test_damaged_files_are_refused_in_one_line(tmp_path, change, words):
    path = damaged(tmp_path, change)
    with pytest.raises(PlanFolderError, match=words) as caught:
        read_trajectory(path)
    message = str(caught.value)
    assert message.startswith(str(path)) and "\n" not in message


def test_unreadable_files(tmp_path):
    with pytest.raises(PlanFolderError, match="cannot be read"):
        read_trajectory(tmp_path / "missing.csv")
    (tmp_path / "binary.csv").write_bytes(b"\xff\xfe\x00\x80")
    with pytest.raises(PlanFolderError, match="cannot be read"):
        read_trajectory(tmp_path / "binary.csv")
    with pytest.raises(PlanFolderError, match="cannot be read"):
        read_trajectory(tmp_path)


def ending(end: float, jerk: float, rate: float = 500.0, hold: int = 0) -> Trajectory:
    """Joints of constant jerk up to their end at 1 rad, sampled until the first one at or after it, `hold` more."""
    t = np.arange(np.ceil(end * rate - 1e-9) + 1 + hold) / rate
    left = np.clip(end - t, 0.0, None)[:, None]
    jerks = jerk * np.array([1.0, -0.5, 0.0, 0.2, 0.0, 1.0])
    return replace(
        trajectory_of(np.zeros((len(t), 34))),
        t=t,
        joint_position=1 - jerks * left**3 / 6,
        joint_speed=jerks * left**2 / 2,
    )


@settings(deadline=None)
@given(end=st.floats(0.1, 0.2), jerk=st.floats(30.0, 1000.0), hold=st.integers(0, 5))
def test_end_time_between_samples(end, jerk, hold):
    """Distance J tau^3/6 and speed J tau^2/2 give tau = 3 distance/speed."""
    trajectory = ending(end, jerk, hold=hold)
    assert trajectory.end_time == pytest.approx(end, abs=2e-6)


@settings(deadline=None)
@given(end=st.floats(0.1, 0.2), jerk=st.floats(30.0, 1000.0), hold=st.integers(0, 5))
def test_the_first_sample_at_rest(end, jerk, hold):
    """Nothing moves from it on, something does before it, and rest that is appended changes nothing."""
    trajectory = ending(end, jerk, hold=hold)
    first = int(np.flatnonzero(trajectory.t == trajectory.rest_time)[0])
    assert trajectory.t[first - 1] < end <= trajectory.rest_time + 2e-6
    assert np.max(np.abs(trajectory.joint_position[first:] - 1.0)) < 1e-12
    assert trajectory.rest_time == ending(end, jerk, hold=hold + 3).rest_time


@pytest.mark.parametrize("samples", [50, 63])
def test_an_end_at_a_sample_is_at_rest_there(samples):
    assert ending(samples / 500.0, 300.0, hold=4).rest_time == pytest.approx(samples / 500.0, abs=1e-12)


def test_end_time_of_planned_motions(smooth_motion):
    motion = smooth_motion("matrix-liquid")
    assert motion.trajectory.end_time == pytest.approx(motion.stages.duration, abs=1e-3)


def test_end_time_whatever_else_is_recorded():
    """Rest may be appended, with any s and any speed in it: the joints stand when they stand."""
    trajectory = ending(0.1, 500.0, hold=1000)
    assert replace(trajectory, s=1 - 3e-7 * (trajectory.t < 2.0)).end_time == trajectory.end_time
    for speed in (0.0, 1e-9, -1.0):
        changed = replace(trajectory, joint_speed=speed + 0 * trajectory.joint_speed)
        assert changed.end_time <= 0.1 + 0.01 + 2e-3
    assert replace(trajectory, joint_position=1.0 + 0 * trajectory.joint_position).end_time == trajectory.t[-1]


@pytest.mark.parametrize("order", [0, 1, 2])
def test_a_motion_is_the_integral_of_its_derivative(smooth_motion, order):
    """Boole's rule over every piece between two samples is exact for its polynomials, of the fifth degree at most."""
    trajectory = smooth_motion("matrix-rigid", cargo=1).trajectory
    h = np.diff(trajectory.t)
    nodes = trajectory.t[:-1, None] + h[:, None] * np.linspace(0.0, 1.0, 5)
    rates = trajectory(nodes.ravel(), order + 1).reshape(*nodes.shape, -1)
    risen = h[:, None] * np.einsum("k,mkn->mn", np.array([7, 32, 12, 32, 7]) / 90, rates)
    size = np.max(np.abs(trajectory(trajectory.t, order)))
    np.testing.assert_allclose(np.diff(trajectory(trajectory.t, order), axis=0), risen, atol=1e-10 * size)


@pytest.mark.parametrize(("order", "size"), [(0, 1e-8), (1, 1e-7), (2, 1e-5), (3, 1e-3)])
def test_a_motion_and_its_derivatives_are_continuous_at_the_samples(smooth_motion, order, size):
    trajectory, aside = smooth_motion("matrix-rigid", cargo=1).trajectory, 1e-9
    inner = trajectory.t[1:-1]
    np.testing.assert_allclose(trajectory(inner - aside, order), trajectory(inner + aside, order), atol=size)


def test_a_motion_passes_through_its_samples_and_stands_at_both_ends(smooth_motion):
    trajectory = smooth_motion("mixed-tray", tilt=(0.1, 0.1)).trajectory
    np.testing.assert_allclose(trajectory(trajectory.t), trajectory.joint_position, atol=1e-13)
    for end in trajectory.t[[0, -1]]:
        assert np.max(np.abs(trajectory(end, 1))) < 1e-4


def test_one_time_gives_one_row(smooth_motion):
    trajectory = smooth_motion("matrix-rigid").trajectory
    for order in range(4):
        many = trajectory([0.2, 0.7], order)
        assert many.shape == (2, len(trajectory.joints))
        np.testing.assert_array_equal(trajectory(0.7, order), many[1])
    assert trajectory(np.empty(0)).shape == (0, len(trajectory.joints))
    # counted in steps, a last time may be behind the last sample by what rounding makes of it
    np.testing.assert_allclose(trajectory(trajectory.t[-1] + 1e-12), trajectory.joint_position[-1], atol=1e-12)


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ((-1e-3,), r"t = -0.001 s is outside the motion: 0 to"),
        (([0.1, 100.0],), "t = 100 s is outside the motion"),
        ((float("nan"),), "t = nan s is outside the motion"),
        (("noon",), "t = 'noon' is no time"),
        (([[0.1], [0.2]],), r"t has the shape \(2, 1\)"),
        ((0.1, 4), "order 4 of a motion: 0"),
        ((0.1, -1), "order -1 of a motion"),
        ((0.1, 1.5), "order 1.5 of a motion"),
    ],
)
def test_what_is_no_time_and_no_order_is_refused_in_one_line(smooth_motion, arguments, message):
    with pytest.raises(ScenarioError, match=message) as caught:
        smooth_motion("matrix-rigid").trajectory(*arguments)
    assert "\n" not in str(caught.value)
