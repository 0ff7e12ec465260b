"""The laboratory's file: what is written is what is read, and nothing else is accepted."""

from __future__ import annotations

import os
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from nospill.errors import NospillError, PlanFolderError, ScenarioError
from nospill.export.lab_csv import LAB_CSV, read_lab_csv, write_lab_csv
from nospill.motion.interpolation import JointSamples
from tests.measured import measured_data


def motion(samples: int = 40, joints: int = 6, rate: float = 500.0) -> np.ndarray:
    """A rest-to-rest quintic in every joint, with different ends."""
    u = np.linspace(0.0, 1.0, samples)[:, None]
    return np.linspace(-1.3, 2.1, joints) + np.linspace(0.5, -3.0, joints) * (10 * u**3 - 15 * u**4 + 6 * u**5)


def test_format_to_the_letter(tmp_path: Path) -> None:
    path = tmp_path / "robot.csv"
    q = motion(3)
    write_lab_csv(q, path, rate=500.0)
    lines = path.read_text().split("\n")
    assert lines[-1] == ""
    assert len(lines) - 1 == 500 + 3
    assert set(lines[:500]) == {lines[500]}
    assert lines[0] == ";".join(f"{value:.12f}" for value in q[0])
    assert lines[502] == ";".join(f"{value:.12f}" for value in q[-1])
    assert not any(character.isalpha() or character.isspace() for line in lines for character in line)


def test_acceleration_survives_the_rounding(tmp_path: Path) -> None:
    q = motion(900)
    write_lab_csv(q, tmp_path / "robot.csv", rate=500.0)
    t, back = read_lab_csv(tmp_path / "robot.csv", rate=500.0)
    assert np.allclose(np.diff(t), 0.002, atol=1e-15)
    assert np.max(np.abs(np.diff(back, 2, axis=0) - np.diff(q, 2, axis=0))) * 500.0**2 < 1e-6


@settings(deadline=None)
@given(
    steps=hnp.arrays(float, st.tuples(st.integers(1, 8), st.just(6)), elements=st.floats(1e-9, 0.1)),
    start=hnp.arrays(float, 6, elements=st.floats(-50, 50)),
    hold=st.floats(1.0, 1.2),
)
def test_round_trip(
    tmp_path_factory: pytest.TempPathFactory, steps: np.ndarray, start: np.ndarray, hold: float
) -> None:
    """Any motion whose first step is more than the rounding comes back sample for sample."""
    path = tmp_path_factory.mktemp("lab") / "robot.csv"
    q = start + np.vstack([np.zeros(6), np.cumsum(steps, axis=0)])
    write_lab_csv(q, path, rate=500.0, hold=hold)
    t, back = read_lab_csv(path, rate=500.0)
    assert t[0] == 0.0
    assert back.shape == q.shape
    assert np.max(np.abs(back - q)) <= 0.5e-12 + 1e-14


def test_no_negative_zero(tmp_path: Path) -> None:
    write_lab_csv(np.array([[-0.0] * 6, [-1e-15] * 6, [1.0] * 6]), tmp_path / "robot.csv", rate=500.0)
    assert "-" not in (tmp_path / "robot.csv").read_text()


@pytest.mark.parametrize(
    ("joints", "options", "message"),
    [
        (motion(joints=7), {"rate": 500.0}, r"6 columns; this motion has 7 joints"),
        (motion()[:, 0], {"rate": 500.0}, r"6 columns; this motion has 0 joints"),
        (motion(), {"rate": 250.0}, r"rate is 250 Hz; the lab's controller plays 500 rows"),
        (motion(), {"rate": float("nan")}, r"rate is nan Hz"),
        (motion() * np.nan, {"rate": 500.0}, r"at least 2 samples, all finite"),
        (motion()[:1], {"rate": 500.0}, r"at least 2 samples, all finite; this motion has 1"),
        (motion(), {"rate": 500.0, "hold": 0.9}, r"hold is 0\.9 s; the lab's controller wants 1 s"),
        (motion(), {"rate": 500.0, "hold": float("nan")}, r"hold is nan s"),
        (motion(), {"rate": 500.0, "hold": float("inf")}, r"hold is inf s"),
    ],
)
def test_what_does_not_fit_is_not_written(tmp_path: Path, joints: np.ndarray, options: dict, message: str) -> None:
    with pytest.raises(ScenarioError, match=message) as caught:
        write_lab_csv(joints, tmp_path / "robot.csv", **options)
    assert "\n" not in str(caught.value)
    assert os.listdir(tmp_path) == []


def lab_text(rest: int = 500) -> list[str]:
    return ["0;0;0;0;0;0"] * rest + ["1;0;0;0;0;0", "2;0;0;0;0;0"]


@pytest.mark.parametrize(
    ("lines", "message"),
    [
        ([], r"starts with 0 identical rows"),
        (lab_text(499), r"starts with 499 identical rows; the lab's format wants 500 or more"),
        (["q1;q2;q3;q4;q5;q6", *lab_text()], r'line 1: "q1;q2;q3;q4;q5;q6" is not six finite numbers'),
        ([*lab_text(), "1;2;3;4;5"], r'line 503: "1;2;3;4;5" is not six'),
        ([*lab_text(), "1;2;3;4;5;6;7"], r"line 503"),
        ([*lab_text(), "1;2;3;nan;5;6"], r"line 503"),
        ([*lab_text(), "1;2;3;inf;5;6"], r"line 503"),
        ([*lab_text(), "", "1;2;3;4;5;6"], r'line 503: "" is not six'),
        (["1,2,3,4,5,6"], r"line 1"),
        (["0,5;0;0;0;0;0"], r"line 1"),
    ],
)
def test_damaged_files_name_the_line(tmp_path: Path, lines: list[str], message: str) -> None:
    path = tmp_path / "robot.csv"
    path.write_text("\n".join(lines))
    with pytest.raises(PlanFolderError, match=message) as caught:
        read_lab_csv(path, rate=500.0)
    assert str(path) in str(caught.value)


def test_windows_line_ends_and_blank_end_are_read(tmp_path: Path) -> None:
    path = tmp_path / "robot.csv"
    path.write_bytes("\r\n".join([*lab_text(), "", ""]).encode())
    t, q = read_lab_csv(path, rate=500.0)
    assert t.tolist() == [0.0, 0.002, 0.004]
    assert q[:, 0].tolist() == [0.0, 1.0, 2.0]


def test_file_that_never_moves(tmp_path: Path) -> None:
    path = tmp_path / "robot.csv"
    path.write_text("\n".join(["1;2;3;4;5;6"] * 600))
    t, q = read_lab_csv(path, rate=500.0)
    assert t.tolist() == [0.0]
    assert q.tolist() == [[1, 2, 3, 4, 5, 6]]


def test_unreadable(tmp_path: Path) -> None:
    (tmp_path / "binary.csv").write_bytes(b"\xff\xfe\x00")
    for path in (tmp_path / "missing.csv", tmp_path, tmp_path / "binary.csv"):
        with pytest.raises(PlanFolderError, match=r"^cannot read .*; write it again with nospill plan$"):
            read_lab_csv(path, rate=500.0)


@pytest.mark.parametrize(("rate", "joints"), [(1000.0, 6), (500.0, 7)])
def test_a_scene_that_does_not_fit_is_refused_before(tmp_path: Path, rate: float, joints: int) -> None:
    scene: Any = SimpleNamespace(robot=SimpleNamespace(joints=tuple(f"j{i}" for i in range(joints))))
    reason = LAB_CSV.reason_against(scene, rate)
    assert reason
    with pytest.raises(NospillError) as caught:
        LAB_CSV.write(JointSamples(np.arange(40) / rate, motion(joints=joints)), scene, tmp_path / "a.csv")
    assert str(caught.value) == reason


@pytest.mark.oracle
@pytest.mark.parametrize("name", ["executed-joints-liquid.csv", "executed-joints-rigid-tilt.csv"])
def test_published_motions_go_through_unchanged(tmp_path: Path, name: str) -> None:
    source = measured_data(f"matrix-d3/{name}")
    table = np.loadtxt(source, delimiter=",", skiprows=1)
    write_lab_csv(table[:, 1:], tmp_path / "robot.csv", rate=500.0)
    t, q = read_lab_csv(tmp_path / "robot.csv", rate=500.0)
    assert np.max(np.abs(q - table[:, 1:])) <= 0.5e-12 + 1e-14
    assert np.allclose(t, table[:, 0], atol=1e-9)
