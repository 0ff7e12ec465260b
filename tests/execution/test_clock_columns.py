"""Columns of times, as recorders name them and in their units: found by what they are, or refused; nothing assumed."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, assume, given, settings
from hypothesis import strategies as st

from nospill.errors import ScenarioError
from nospill.execution.csv_logs import read_table
from nospill.execution.log import JointLog, log_of_joints

JOINTS = ("joint_a", "joint_b")
COUNT = 60
NAMES = ("robot_time", "__time", "IPOC", "header.stamp", "rtime", "Clock", "elapsed", "t", "Zeitstempel")
FACTORS = {"s": 1.0, "ms": 1e3, "us": 1e6, "ns": 1e9}


def positions(t: np.ndarray) -> np.ndarray:
    return np.column_stack([0.3 * np.sin(2.0 * t), 0.1 + 0.2 * np.cos(3.0 * t)])


def write(
    place: Path, columns: dict[str, np.ndarray], separator: str = ",", comma: bool = False, mark: str = ""
) -> Path:
    lines = [separator.join(columns)]
    for row in zip(*(values.tolist() for values in columns.values()), strict=True):
        cells = [value if isinstance(value, str) else repr(value) for value in row]
        lines.append(separator.join(cell.replace(".", ",") if comma else cell for cell in cells))
    place.write_text(mark + "\n".join(lines) + "\n", encoding="utf-8")
    return place


def read(place: Path, rate: float | None = None) -> JointLog:
    return log_of_joints(read_table(place, joints=2), JOINTS, rate=rate)


@given(
    name=st.sampled_from(NAMES),
    unit=st.sampled_from(sorted(FACTORS)),
    stated=st.booleans(),
    period=st.sampled_from([1e-3, 2e-3, 4e-3, 8e-3, 0.012, 0.02]),
    start=st.sampled_from([0.0, 12.5, 1.7e9]),
    order=st.permutations(range(5)),
    style=st.sampled_from([(",", False), (";", False), (";", True), ("\t", True), ("\t", False)]),
    degrees=st.booleans(),
    missing=st.sets(st.integers(1, COUNT - 2), max_size=3),
    wrapped=st.booleans(),
    mark=st.sampled_from(["", "\ufeff"]),
)
@settings(max_examples=80, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
def test_drawn_logs_are_read_as_what_they_are(
    tmp_path: Path, name, unit, stated, period, start, order, style, degrees, missing, wrapped, mark
) -> None:
    """Whatever the names, the units, the order and the marks: the times and angles of the file, and what was read."""
    assume(stated or name != "Zeitstempel" or period * FACTORS[unit] != 1.0)  # which nothing tells from a counter
    t = period * np.arange(COUNT)
    q = positions(t) + (3.05 if wrapped else 0.0)
    told = np.mod(q + np.pi, 2.0 * np.pi) - np.pi if wrapped else q
    factor = 180.0 / np.pi if degrees else 1.0
    times = np.array(
        [repr(float(value)) if unit == "s" else str(round(value)) for value in FACTORS[unit] * (start + t)]
    )
    angles = (told * factor).astype(object)
    for row in missing:
        angles[row, 0] = "nan"
    columns = [
        (f"{name}_{unit}" if stated else name, times),
        ("joint_b_deg" if degrees else "joint_b_rad", angles[:, 1]),
        ("joint_a [deg]" if degrees else "joint_a", angles[:, 0]),
        ("current_1", np.linspace(3.0, 1.0, COUNT)),
        ("mode", np.array(["RUNNING"] * COUNT)),
    ]
    separator, comma = style
    place = write(tmp_path / "log.csv", dict(columns[index] for index in order), separator, comma, mark)
    found, kept = read(place), np.array([row for row in range(COUNT) if row not in missing])
    precision = 1e-6 if start > 1e6 else 2e-9
    assert found.t - found.t[0] == pytest.approx(t[kept] - t[0], abs=precision)
    assert found.position - found.position[0] == pytest.approx(q[kept] - q[0], abs=1e-9)
    assert f"{len(kept)} rows, time from {name.lower()} ({unit}" in found.read
    assert ("by its steps" in found.read) == (not stated)
    assert ("without a number left out" in found.read) == bool(missing)
    others = "columns not read: current_1, mode" in found.read or "columns not read: mode, current_1" in found.read
    assert others


def test_seconds_and_nanoseconds_of_ros(tmp_path: Path) -> None:
    t = 0.002 * np.arange(COUNT) + 0.9
    nanoseconds = np.round(t * 1e9).astype(int)
    whole, part = 1_700_000_000 + nanoseconds // 10**9, nanoseconds % 10**9
    columns = {"sec": whole, "nanosec": part, "q1": positions(t)[:, 0], "q2": positions(t)[:, 1]}
    found = read(write(tmp_path / "log.csv", columns))
    assert np.diff(found.t) == pytest.approx(np.diff(t), abs=1e-9)
    assert "time from sec and nanosec" in found.read


def test_a_clock_without_a_name_of_times(tmp_path: Path) -> None:
    t = 0.002 * np.arange(COUNT)
    columns = {"c0": t + 5.0, "q1": positions(t)[:, 0], "q2": positions(t)[:, 1]}
    assert "time from c0 (s by its steps)" in read(write(tmp_path / "log.csv", columns)).read


@pytest.mark.parametrize(
    ("others", "says"),
    [
        ({}, r"no column of times among the others \(none\)"),
        ({"current": np.linspace(3.0, 1.0, COUNT)}, r"no column of times among the others \(current\)"),
        ({"seq": np.arange(COUNT)}, "seq counts the rows and is no time; give rows a second, as --rate 500"),
        ({"a": 0.002 * np.arange(COUNT), "b": 0.004 * np.arange(COUNT)}, "a and b could each be times"),
        (
            {"time": 0.002 * np.arange(COUNT), "robot_time": 0.0032 * np.arange(COUNT)},
            "time and robot_time both look like times, and the second runs 1.6 times as fast",
        ),
        ({"t_s": 2.0 * np.arange(COUNT)}, "t_s is named in s|steps of 2"),
        ({"time": 0.22 * np.arange(COUNT)}, "steps of 0.22 in time are of no unit of time that a recorder has"),
    ],
)
def test_what_is_no_clock_is_refused_by_its_name(tmp_path: Path, others: dict, says: str) -> None:
    q = positions(0.002 * np.arange(COUNT))
    place = write(tmp_path / "log.csv", {**others, "q1": q[:, 0], "q2": q[:, 1]})
    with pytest.raises(ScenarioError, match=says) as caught:
        read(place)
    assert "\n" not in str(caught.value) and "log.csv" in str(caught.value)
    if "time" not in others and "t_s" not in others:
        assert read(place, rate=250.0).t == pytest.approx(np.arange(COUNT) / 250.0)
