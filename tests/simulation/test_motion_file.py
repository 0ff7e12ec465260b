"""Motions and heights from CSV: what is read, what is refused and how it is said."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from nospill.errors import PlanFolderError, ScenarioError
from nospill.simulation.motion_file import Heights, checked_motion, read_heights, read_motion, write_heights

HEADER = "t_s,x_m,y_m,z_m,qx,qy,qz,qw"


def rows(count: int = 20) -> list[str]:
    return [f"{0.002 * i:.3f},{0.1 * i},0,0.5,0,0,0,1" for i in range(count)]


def write(folder: Path, lines: list[str], header: str = HEADER) -> Path:
    file = folder / "motion.csv"
    file.write_text("\n".join([header, *lines]) + "\n")
    return file


def test_reads_poses(tmp_path: Path) -> None:
    motion = read_motion(write(tmp_path, rows()))
    assert motion.t.shape == (20,) and motion.position.shape == (20, 3) and motion.quaternion.shape == (20, 4)
    assert motion.position[3] == pytest.approx([0.3, 0.0, 0.5])
    assert not motion.t.flags.writeable


def test_byte_order_mark_spaces_and_blank_lines_are_harmless(tmp_path: Path) -> None:
    file = tmp_path / "motion.csv"
    file.write_text("\ufeff" + HEADER.replace(",", ", ") + "\n" + "\n".join(rows()) + "\n\n", encoding="utf-8")
    assert len(read_motion(file).t) == 20


def spoil(index: int, line: str) -> Callable[[list[str]], list[str]]:
    return lambda lines: [*lines[:index], line, *lines[index + 1 :]]


BAD: dict[str, tuple[Callable[[list[str]], list[str]], str]] = {
    "missing value": (spoil(4, "0.008,,0,0,0,0,0,1"), r"line 6: x_m is missing; fill the gap"),
    "short row": (spoil(4, "0.008,0,0"), r"line 6: 3 values where 8 are needed"),
    "nan": (spoil(4, "0.008,nan,0,0,0,0,0,1"), r"line 6: x_m is nan; fill the gap"),
    "infinite": (spoil(4, "0.008,0,inf,0,0,0,0,1"), r"line 6: y_m is inf"),
    "word": (spoil(4, "0.008,0,0,lost,0,0,0,1"), r"line 6: z_m is 'lost', not a number"),
    "repeated time": (spoil(4, "0.006,0,0,0,0,0,0,1"), r"line 6: t = 0.006 s is repeated; times must increase"),
    "unsorted time": (spoil(4, "0.001,0,0,0,0,0,0,1"), r"line 6: t = 0.001 s comes after 0.006 s; times must increase"),
    "gap in time": (lambda lines: lines[:6] + lines[9:], r"line 8: time jumps from 0.01 s to 0.018 s .*without gaps"),
    "long quaternion": (spoil(4, "0.008,0,0,0,0,0,0,1.01"), r"line 6: quaternion .* has length 1.01; it must be 1"),
    "zero quaternion": (spoil(4, "0.008,0,0,0,0,0,0,0"), r"line 6: quaternion .* has length 0; it must be 1"),
    "too few rows": (lambda lines: lines[:5], r"5 rows of values; at least 8 are needed"),
    "no rows": (lambda lines: [], r"0 rows of values; at least 8 are needed"),
}


@pytest.mark.parametrize("fault", BAD)
def test_refuses_wrong_rows_in_one_line(tmp_path: Path, fault: str) -> None:
    change, message = BAD[fault]
    file = write(tmp_path, change(rows()))
    with pytest.raises(ScenarioError, match=message) as caught:
        read_motion(file)
    assert str(caught.value).startswith(str(file)) and "\n" not in str(caught.value)


@pytest.mark.parametrize("header", ["", "t_s,height_mm", "t_s;x_m;y_m;z_m;qx;qy;qz;qw", "t_s,x_m,y_m,z_m,qw,qx,qy,qz"])
def test_refuses_other_columns(tmp_path: Path, header: str) -> None:
    with pytest.raises(ScenarioError, match=f"line 1: the columns are .*; they must be {HEADER}"):
        read_motion(write(tmp_path, rows(), header=header))


def test_refuses_files_that_cannot_be_read(tmp_path: Path) -> None:
    with pytest.raises(ScenarioError, match="does not exist"):
        read_motion(tmp_path / "absent.csv")
    with pytest.raises(ScenarioError, match="is a folder"):
        read_heights(tmp_path)
    binary = tmp_path / "binary.csv"
    binary.write_bytes(b"\xff\xfe\x00\x81")
    with pytest.raises(ScenarioError, match="is not UTF-8 text"):
        read_motion(binary)
    with pytest.raises(ScenarioError, match="cannot be read"):
        read_motion("nul\0name.csv")


def test_quaternions_are_normalised_within_a_thousandth_and_keep_their_side() -> None:
    t = 0.01 * np.arange(30)
    half = 0.5 * np.linspace(0.0, 4.0 * np.pi, 30)
    quaternion = np.column_stack([0 * half, 0 * half, np.sin(half), np.cos(half)])
    flipped = quaternion * np.where(np.arange(30) % 3 == 0, -1.0005, 1.0)[:, None]
    motion = checked_motion(t, np.zeros((30, 3)), flipped)
    assert np.linalg.norm(motion.quaternion, axis=1) == pytest.approx(np.ones(30), abs=1e-12)
    assert np.all(np.sum(motion.quaternion[1:] * motion.quaternion[:-1], axis=1) > 0.0)
    assert np.abs(motion.quaternion) == pytest.approx(np.abs(quaternion), abs=1e-12)


def test_arrays_of_wrong_shape_are_refused() -> None:
    t = 0.01 * np.arange(10)
    for position, quaternion in (((10, 2), (10, 4)), ((9, 3), (10, 4)), ((10, 3), (10, 3))):
        with pytest.raises(ScenarioError, match="shapes of t"):
            checked_motion(t, np.zeros(position), np.ones(quaternion))


@given(st.integers(8, 60), st.floats(0.001, 0.05), st.integers(0, 2**31))
def test_a_jittering_clock_passes_and_a_missing_row_does_not(count: int, step: float, seed: int) -> None:
    random = np.random.default_rng(seed)
    t = step * (np.arange(count) + random.uniform(-0.1, 0.1, count))
    quaternion = np.tile([0.0, 0.0, 0.0, 1.0], (count, 1))
    checked_motion(t, np.zeros((count, 3)), quaternion)
    lost = np.delete(np.arange(count + 1), count // 2)
    late = step * (lost + random.uniform(-0.1, 0.1, count))
    with pytest.raises(ScenarioError, match="time jumps"):
        checked_motion(late, np.zeros((count, 3)), quaternion)


def test_heights_survive_writing_and_reading(tmp_path: Path) -> None:
    t = np.arange(50) / 60.0
    height = 0.02 * np.sin(7.0 * t)
    file = tmp_path / "height.csv"
    write_heights(file, Heights(t, height))
    assert file.read_text().splitlines()[0] == "t_s,height_mm"
    again = read_heights(file)
    assert again.t == pytest.approx(t, abs=1e-6) and again.height == pytest.approx(height, abs=1e-9)


def test_heights_cannot_be_written_into_a_missing_folder(tmp_path: Path) -> None:
    with pytest.raises(PlanFolderError, match="cannot write"):
        write_heights(tmp_path / "absent" / "height.csv", Heights(np.arange(9.0), np.zeros(9)))
