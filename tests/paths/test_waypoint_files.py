"""Waypoint files: columns in any order and unit, attitudes as yaw, and refusals that name file and line."""

from __future__ import annotations

from pathlib import Path as FilePath

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from scipy.spatial.transform import Rotation

from nospill.errors import ScenarioError
from nospill.paths.waypoint_files import read_waypoints


def written(text: str, folder: FilePath) -> FilePath:
    file = folder / "points.csv"
    file.write_text(text, encoding="utf-8")
    return file


@pytest.mark.parametrize(
    "text",
    [
        "0,0,1\n0.5,0,1\n",
        "\ufeffx,y,z\n0,0,1\n0.5,0,1",
        "# recorded by hand\nx [m]; y [m]; z [m]\n\n0;0;1\n5e-1 ; 0 ; 1\n",
        "x_m;y_m;z_m\r\n0;0;1\r\n0.5;0;1\r\n",
        "x_mm,y_mm,z_mm\n0,0,1000\n500,0,1000\n",
        "t,z (cm),Y,x [mm]\n0,100,0,0\n0.1,100,0,500\n",
        "Time,X,Y,Z\n17,0,0,1\n18,0.5,0,1\n",
    ],
)
def test_files_that_are_read(text: str, tmp_path: FilePath) -> None:
    recorded = read_waypoints(written(text, tmp_path))
    np.testing.assert_allclose(recorded.points, [[0, 0, 1], [0.5, 0, 1]], rtol=1e-15)
    assert recorded.yaw is None
    assert recorded.origin.startswith("points.csv, 2 points")
    assert ("times are not used" in recorded.origin) == (text[0] in "tT")


def test_quaternions_become_a_yaw_without_jumps_and_their_tilt_is_told(tmp_path: FilePath) -> None:
    yaws = np.radians([170.0, 175.0, 185.0, 200.0])
    leaning = np.radians([0.0, 3.0, 1.0, 0.0])
    attitudes = Rotation.from_euler("ZY", np.column_stack([yaws, leaning])).as_quat()
    lines = [f"{0.1 * i},0,1,{','.join(map(repr, row))}" for i, row in enumerate((-attitudes).tolist())]
    recorded = read_waypoints(written("\n".join(["x,y,z,qx,qy,qz,qw", *lines]), tmp_path))
    assert recorded.yaw is not None
    np.testing.assert_allclose(np.diff(recorded.yaw), np.diff(yaws), atol=1e-12)
    np.testing.assert_allclose(np.exp(1j * recorded.yaw), np.exp(1j * yaws), atol=1e-12)
    assert "a tilt of up to 3 deg is not" in recorded.origin


def test_a_yaw_column_needs_its_unit(tmp_path: FilePath) -> None:
    recorded = read_waypoints(written("x,y,z,yaw_deg\n0,0,1,170\n1,0,1,-170\n", tmp_path))
    assert recorded.yaw == pytest.approx(np.radians([170.0, 190.0]))
    with pytest.raises(ScenarioError, match=r'column "yaw" is not known.*yaw_deg or yaw_rad'):
        read_waypoints(written("x,y,z,yaw\n0,0,1,170\n1,0,1,-170\n", tmp_path))


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "0 waypoints; a path needs at least 2"),
        ("x,y,z\n1,2,3\n", "1 waypoints"),
        ("1,2,3\n1,2\n", r"points.csv line 2: 2 columns; 3 are needed \(x, y, z in m, separated"),
        ("x,y,z,t\n1,2,3\n", r"points.csv line 2: 3 columns; 4 are needed \(x, y, z, t"),
        ("1,2,3\n\n1,zwei,3\n", 'points.csv line 3: "zwei" is not a number'),
        ("1;2;3\n1,5;2;3\n", 'points.csv line 2: "1,5" is not a number; write numbers with a decimal point'),
        ("1,2,3\n1,nan,3\n", 'points.csv line 2: "nan" is not a finite number'),
        ("nan,2,3\n1,2,3\n", 'points.csv line 1: "nan" is not a finite number'),
        ("1,2,3\n1,,3\n", 'points.csv line 2: "" is not a number'),
        ("x,y,height\n1,2,3\n1,2,4\n", 'points.csv line 1: header .*: column "height" is not known'),
        ("x,y,z [inch]\n1,2,3\n1,2,4\n", r'line 1: header .*: column "z \[inch\]" is not known'),
        ("x,y,x\n1,2,3\n1,2,4\n", 'column "x" stands there twice'),
        ("x,y,t\n1,2,3\n1,2,4\n", "the columns must be x, y and z"),
        ("x,y,z,qx,qy\n1,2,3,0,0\n1,2,4,0,0\n", "all of qx, qy, qz, qw"),
        ("x,y,z\nx,y,z\n1,2,3\n", 'points.csv line 2: "x" is not a number'),
        (
            "850,0,1200\n850,500,1200\n",
            r"a coordinate of 1200 m, as if the points were in mm; name the unit in a header",
        ),
        ("x,y,z,qx,qy,qz,qw\n0,0,1,0,0,0,1\n1,0,1,0,0,0,2\n", "quaternion of waypoint 2 has the norm 2; it must be 1"),
    ],
)
def test_files_that_are_refused(text: str, message: str, tmp_path: FilePath) -> None:
    with pytest.raises(ScenarioError, match=message) as caught:
        read_waypoints(written(text, tmp_path))
    assert "\n" not in str(caught.value)


def test_files_that_cannot_be_read(tmp_path: FilePath) -> None:
    with pytest.raises(ScenarioError, match=r"missing\.csv: does not exist; give a CSV file"):
        read_waypoints(tmp_path / "missing.csv")
    with pytest.raises(ScenarioError, match="is a folder"):
        read_waypoints(tmp_path)
    (tmp_path / "binary.csv").write_bytes(b"\xff\xfe\x00\x01")
    with pytest.raises(ScenarioError, match="is not UTF-8 text"):
        read_waypoints(tmp_path / "binary.csv")


def test_a_ten_megabyte_file_is_read(tmp_path: FilePath) -> None:
    points = np.random.default_rng(0).normal(size=(1000, 3))
    file = written("\n".join(",".join(map(repr, row)) for row in points.tolist() * 180), tmp_path)
    assert file.stat().st_size > 10e6
    assert read_waypoints(file).points.shape == (180_000, 3)


LENGTHS = {"m": 1.0, "cm": 1e2, "mm": 1e3, "um": 1e6}


@given(
    length=st.sampled_from(["", *LENGTHS]),
    style=st.sampled_from(["{0}_{1}", "{0} [{1}]", "{0} ({1})"]),
    attitude=st.sampled_from(["", "deg", "rad", "quaternion"]),
    times=st.sampled_from(["", "t", "time", "timestamp"]),
    order=st.randoms(use_true_random=False),
    separator=st.sampled_from([",", ";", " , "]),
    mark=st.sampled_from(["", "\ufeff"]),
    fault=st.sampled_from(["", "", "", "nan", "text", "short", "comma", "unknown column", "twice"]),
    flips=st.booleans(),
    end=st.sampled_from(["\n", "\r\n"]),
)
@settings(max_examples=60, deadline=None, suppress_health_check=[HealthCheck.function_scoped_fixture])
def test_drawn_files_are_read_as_what_they_are_or_refused(
    tmp_path: FilePath, length, style, attitude, times, order, separator, mark, fault, flips, end
) -> None:
    """Columns in any order, unit and spelling; what is no table of points is refused with its line."""
    count = 9
    places = np.column_stack([np.linspace(0.4, 0.7, count), np.linspace(-0.3, 0.3, count) ** 3, np.full(count, 0.5)])
    yaw = np.linspace(0.0, 4.0, count)
    factor = LENGTHS.get(length, 1.0)
    columns: dict[str, np.ndarray] = {
        style.format(axis, length) if length else axis: factor * places[:, i] for i, axis in enumerate("xyz")
    }
    if attitude == "quaternion":
        signs = np.where(np.arange(count) % 3 == 1, -1.0, 1.0) if flips else np.ones(count)
        quaternions = signs[:, None] * Rotation.from_euler("z", yaw[:, None]).as_quat()
        columns |= dict(zip(("qx", "qy", "qz", "qw"), quaternions.T, strict=True))
    elif attitude:
        angles = np.mod(yaw + np.pi, 2.0 * np.pi) - np.pi if flips else yaw
        columns[f"yaw_{attitude}"] = angles * (180.0 / np.pi if attitude == "deg" else 1.0)
    if times:
        columns[times] = 0.1 * np.arange(count)
    if fault == "unknown column":
        columns["roll"] = np.zeros(count)
    names = list(columns)
    order.shuffle(names)
    rows = [[repr(float(columns[name][row])) for name in names] for row in range(count)]
    if fault == "nan":
        rows[4][0] = "nan"
    elif fault == "text":
        rows[4][0] = "N/A"
    elif fault == "short":
        rows[4] = rows[4][:-1]
    elif fault == "comma":
        rows[4] = [cell.replace(".", ",") for cell in rows[4]]
    if fault == "twice":
        names[-1] = names[0]
    text = end.join([separator.join(names), *(separator.join(row) for row in rows)]) + end
    place = tmp_path / "points.csv"
    place.write_bytes((mark + text).encode("utf-8"))
    if fault:
        with pytest.raises(ScenarioError) as caught:
            read_waypoints(place)
        line = 1 if fault in ("unknown column", "twice") else 6
        assert f"points.csv line {line}" in str(caught.value) and "\n" not in str(caught.value)
        return
    recorded = read_waypoints(place)
    np.testing.assert_allclose(recorded.points, places, atol=1e-12)
    assert ("coordinates taken as m" in recorded.origin) == (not length)
    assert ("times are not used" in recorded.origin) == bool(times)
    if attitude:
        assert recorded.yaw is not None
        turned = recorded.yaw - recorded.yaw[0] - (yaw - yaw[0])
        np.testing.assert_allclose(turned, 0.0, atol=1e-9)
    else:
        assert recorded.yaw is None
