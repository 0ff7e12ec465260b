"""Heights from films: rendered ones, since none is at hand."""

from __future__ import annotations

import csv
import json
from pathlib import Path

import numpy as np
import pytest
from typer.testing import CliRunner, Result

from benchmarks.filmed.accuracy import errors, moved
from benchmarks.filmed.rendering import Scene, View, Wave, write_film
from nospill.cli import app
from nospill.measuring.measured import FilmedHeights, measured_heights
from nospill.measuring.region import Finder, Vessel
from nospill.measuring.surface import edges, line
from nospill.simulation.motion_file import read_heights

RATE = 100.0
VIEW = View(scale=5e-4, size=(336, 240), foam=0.0015, glare=120.0, drops=10, elevation=0.08, turn=0.05, seed=4)
WAVE = Wave(lambda t: 0.009 * np.sin(22.6 * max(t - 0.03, 0.0)), lambda t: 0.003 * np.sin(22.6 * max(t - 0.03, 0.0)))
VESSEL = Vessel(VIEW.radius, VIEW.height, VIEW.marker, -VIEW.marker_at)
OPTIONS = ["--radius", "35 mm", "--height", "99 mm", "--marker", "40 mm", "--axis", "70 mm"]
COUNT, HIDDEN_MARKER, HIDDEN_VESSEL = 11, 6, 8


@pytest.fixture(scope="module")
def place(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A film of eleven frames, one with a hidden marker, one with a hidden vessel; and one without a marker."""
    folder = tmp_path_factory.mktemp("films")
    scene = Scene(VIEW)
    pictures = [scene.frame(number / RATE, WAVE) for number in range(COUNT)]
    write_film(folder / "bare.mp4", [own[:, 170:] for own in pictures[:4]], RATE)
    pictures[HIDDEN_MARKER][:, :120] = 90
    pictures[HIDDEN_VESSEL][:, 180:] = 90
    write_film(folder / "film.mp4", pictures, RATE)
    (folder / "text.mp4").write_text("no film")
    return folder


@pytest.fixture(scope="module")
def found(place: Path) -> FilmedHeights:
    return measured_heights(place / "film.mp4", VESSEL, rest=0.03)


def run(*arguments: str) -> Result:
    return CliRunner().invoke(app, ["measure", *arguments])


def test_heights_of_both_walls(found: FilmedHeights) -> None:
    scene = Scene(VIEW)
    off = errors(found, np.array([scene.walls(number / RATE, WAVE) for number in range(COUNT)]))
    assert np.sqrt(np.mean(off**2)) < 0.5e-3
    assert np.ptp(found.left) > 5e-3
    assert found.scale == pytest.approx(VIEW.scale, rel=0.02)
    assert not found.brighter


def test_a_camera_in_the_room_sees_the_same_heights(tmp_path: Path) -> None:
    times = [number / RATE for number in range(COUNT)]
    scenes = [Scene(moved(VIEW, 8.0 * t, seed=1), np.random.default_rng(round(RATE * t))) for t in times]
    pictures = [scene.frame(t, WAVE) for scene, t in zip(scenes, times, strict=True)]
    write_film(tmp_path / "film.mp4", pictures, RATE)
    corners = np.array([Finder(VESSEL).corners(own) for own in pictures])
    assert np.ptp(corners[:, 0, 0]) > 10.0  # pixels
    seen = measured_heights(tmp_path / "film.mp4", VESSEL, rest=0.03)
    assert not seen.lost
    off = errors(seen, np.array([scene.walls(t, WAVE) for scene, t in zip(scenes, times, strict=True)]))
    assert np.sqrt(np.mean(off**2)) < 0.5e-3


def test_lost_frames_are_named_and_not_invented(found: FilmedHeights) -> None:
    assert [(round(t * RATE), reason) for t, reason in found.lost] == [
        (HIDDEN_MARKER, "no marker"),
        (HIDDEN_VESSEL, "no surface"),
    ]
    assert len(found.t) == 9
    assert np.min(found.confidence) > 0.8


def test_command_writes_what_compare_reads(place: Path, tmp_path: Path) -> None:
    film, table = str(place / "film.mp4"), tmp_path / "heights.csv"
    result = run(film, *OPTIONS, "--rest", "0.03 s", "--side", "left", "-o", str(table))
    assert result.exit_code == 0, result.output
    for phrase in ("9 of 11 frames", "lost, no marker: t = 0.060 s", "lost, no surface: t = 0.080 s"):
        assert phrase in result.output, phrase
    with table.open() as file:
        rows = list(csv.DictReader(file))
    assert list(rows[0]) == ["t_s", "height_mm", "left_mm", "right_mm", "confidence"]
    heights = read_heights(table)
    assert len(heights.t) == 9
    np.testing.assert_allclose(1e3 * heights.height, [float(row["left_mm"]) for row in rows])


def test_record_as_json_and_another_rate(place: Path) -> None:
    result = run(str(place / "film.mp4"), *OPTIONS, "--rest", "0.015 s", "--rate", "200", "--json")
    record = json.loads(result.stdout)
    assert record["t_s"][1] == pytest.approx(0.005)
    assert [own["reason"] for own in record["lost"]] == ["no marker", "no surface"]


@pytest.mark.parametrize(
    ("film", "changes", "message"),
    [
        ("bare.mp4", {}, "no marker in any of 4 frames"),
        ("text.mp4", {}, "cannot be read as a film"),
        ("none.mp4", {}, "no such file"),
        ("film.mp4", {"--axis": "-70 mm"}, "no surface of a liquid"),
        ("film.mp4", {"--rest": "0.11 s"}, "the film must begin with the liquid at rest"),
        ("film.mp4", {"--rest": "1 ms"}, "1 frames of the first 0.001 s show the surface"),
        ("film.mp4", {"--side": "top"}, "--side top: must be one of higher, left, right"),
        ("film.mp4", {"--marker": "0 mm"}, "--marker 0 mm: must be above zero"),
        ("film.mp4", {"--radius": "35"}, "--radius: "),
    ],
)
def test_bad_input_is_one_line_and_exit_code_2(place: Path, film: str, changes: dict[str, str], message: str) -> None:
    options = dict(zip(OPTIONS[::2], OPTIONS[1::2], strict=True)) | {"--rest": "0.03 s"} | changes
    result = run(str(place / film), *(text for pair in options.items() for text in pair))
    assert result.exit_code == 2, result.output
    assert message in result.output
    assert len(result.output.strip().splitlines()) == 1


def test_a_liquid_brighter_than_its_background() -> None:
    scene = Scene(VIEW)
    frame = scene.frame(0.0, WAVE)
    finder = Finder(VESSEL)
    corners = finder.corners(frame)
    assert corners is not None
    dark = line(edges(finder.region(frame, corners, VIEW.scale), -1.0))
    bright = line(edges(finder.region(255 - frame, corners, VIEW.scale), 1.0))
    assert dark is not None
    assert bright is not None
    assert bright.left == pytest.approx(dark.left, abs=2e-4)
