"""What a sweep writes: table, figures by the number of axes, a page whose points can be picked."""

from __future__ import annotations

import csv
import io
import json
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from nospill.plots.sweeps import pareto_front, sweep_figures
from nospill.sweeps.definition import SweepDefinition, define_sweep, read_sweep
from nospill.sweeps.points import Line
from nospill.sweeps.record import Sweep
from nospill.sweeps.writing import picture_of, write_sweep
from tests.cli.commands import nospill

SWEEP = """
scenario = "matrix-rigid"
[[axis]]
key = "tray.friction"
from = 0.3
to = 0.5
count = 3
[[axis]]
key = "motion.tilt"
values = ["fixed", "free"]
[columns]
moves_an_hour = "3600 / duration_s"
[goals]
duration_s = "least"
friction = "least"
"""


def planned(definition: SweepDefinition) -> Sweep:
    """A sweep whose first point has no motion, and whose others are the sooner the later they come."""
    lines = [
        Line(point.key, point.values, "planned", figures={"duration_s": 2.0 - 0.01 * index}, nearest="slip of c1")
        for index, point in enumerate(definition.points)
    ]
    lines[0] = Line(lines[0].key, lines[0].values, "no motion", reason="No motion found: </script><b>slip")
    return Sweep(definition, tuple(lines))


def defined(axes: dict[Any, Any], **options: Any) -> Sweep:
    return planned(define_sweep("matrix-rigid", axes, **options))


def test_the_table_has_derived_columns_and_empty_cells_where_there_is_no_motion(tmp_path: Path) -> None:
    file = tmp_path / "s.toml"
    file.write_text(SWEEP)
    found = planned(read_sweep(file))
    rows = list(csv.DictReader(io.StringIO(found.csv())))
    assert [row["tray.friction"] for row in rows] == ["0.3", "0.3", "0.4", "0.4", "0.5", "0.5"]
    assert rows[0]["duration_s"] == "" and float(rows[5]["moves_an_hour"]) == pytest.approx(3600 / 1.95)
    assert found.best is found.lines[5] and found.column("friction")[5] == 0.5
    assert found.headline == "6 of 6 points planned, 5 certified"


@pytest.mark.parametrize("axes", [1, 2, 3])
def test_figures_by_the_number_of_axes(axes: int) -> None:
    keys = {"tray.friction": [0.3, 0.4, 0.6], "motion.tilt": ["fixed", "free"], "tray.mass": ["1 kg", "2 kg"]}
    found = defined(dict(list(keys.items())[:axes]))
    figure = sweep_figures(picture_of(found))["sweep"]
    assert list(sweep_figures(picture_of(found))) == ["sweep"]
    labels = [axes.get_xlabel() for axes in figure.axes]
    assert labels[0] == "tray.friction" and ("tray.mass [kg]" in labels) == (axes == 3)
    if axes == 2:
        [cells] = figure.axes[0].collections
        assert np.ma.count(np.ma.asarray(cells.get_array())) == 5  # one of six has no motion


@given(st.lists(st.tuples(st.integers(0, 5), st.integers(0, 5)), min_size=1, max_size=30))
def test_nothing_beats_a_point_of_the_pareto_front(points: list[tuple[int, int]]) -> None:
    values = np.array(points, dtype=float)
    front = pareto_front(values)
    for index, own in enumerate(points):
        beaten = any(a <= own[0] and b <= own[1] and (a, b) != own for a, b in points)
        assert front[index] != beaten


def test_the_page_holds_every_point_with_the_command_that_opens_it(tmp_path: Path) -> None:
    file = tmp_path / "s.toml"
    file.write_text(SWEEP)
    found = planned(read_sweep(file))
    (tmp_path / "plans" / found.lines[5].key).mkdir(parents=True)
    write_sweep(found, tmp_path, scenario="matrix-rigid")
    page = (tmp_path / "index.html").read_text()
    data = json.loads(re.findall(r"<script id='data' type='application/json'>(.*?)</script>", page)[0])
    assert len(data["rows"]) == 6 and data["best"] == 5
    assert data["open"][1] == {
        "link": None,
        "command": "nospill plan matrix-rigid --set tray.friction=0.3 --set 'motion.tilt=\"free\"' "
        f"-o {found.lines[1].key}",
    }
    assert data["open"][5]["link"] == f"plans/{found.lines[5].key}/"
    assert page.count("<svg") == 3 and not re.findall(r"(?:src|href)=[\"']?http", page)
    assert {path.name for path in (tmp_path / "figures").iterdir()} == {
        "sweep.png",
        "sweep.svg",
        "pareto.png",
        "pareto.svg",
    }


def test_points_of_the_page_open(tmp_path: Path, browser: Any) -> None:
    write_sweep(defined({"tray.friction": [0.3, 0.4]}), tmp_path, scenario="matrix-rigid", figures=False)
    page = browser.new_page()
    faults: list[str] = []
    page.on("pageerror", lambda error: faults.append(str(error)))
    page.goto((tmp_path / "index.html").as_uri())
    assert page.locator("circle").count() == 2 and page.locator("tbody tr").count() == 2
    page.locator("circle.lost").click()
    assert "No motion found: </script><b>slip" in page.locator("#one").inner_text()
    assert "--set tray.friction=0.3" in page.locator("#one code").inner_text()
    page.locator("th", has_text="duration_s").first.click()
    assert page.locator("tbody tr").first.inner_text().startswith("0.4")
    assert faults == []
    page.close()


def test_a_page_of_500_points_has_every_row_and_marks_what_is_picked(tmp_path: Path, browser: Any) -> None:
    """Its plot is there before its last row: rows follow sixty at a time."""
    axes = {"tray.friction": {"from": 0.3, "to": 0.5, "count": 25}, "tray.mass": {"from": 1, "to": 2, "count": 20}}
    write_sweep(defined(axes), tmp_path, scenario="matrix-rigid", figures=False)
    page = browser.new_page()
    page.goto((tmp_path / "index.html").as_uri())
    assert page.locator("circle").count() == 500
    page.wait_for_function("() => document.querySelectorAll('tbody tr').length === 500")
    page.locator("tbody tr").nth(70).click()
    assert page.locator(".chosen").evaluate_all("found => found.map(one => one.dataset.i)") == ["70", "70"]
    page.close()


@pytest.mark.parametrize(
    ("text", "words", "options"),
    [
        (SWEEP, "-o DIR is missing", []),
        (SWEEP, "give one of them", ["-o", "out", "--jobs", "1", "--scheduler", "tcp://a:1"]),
        (SWEEP.replace("[[axis]]", "[[axes]]"), "axes is an unknown key; did you mean axis?", ["-o", "out"]),
        (SWEEP.replace("scenario =", "#"), "scenario is missing", ["-o", "out"]),
        (SWEEP.replace("count = 3", "values = [1]"), "axis 0: give values, or from and to", ["-o", "out"]),
        (SWEEP.replace('key = "tray', 'kez = "tray'), "axis 0: give key, or keys", ["-o", "out"]),
        (SWEEP.replace("tray.friction", "tray.fraction"), "tray.fraction", ["-o", "out"]),
        (SWEEP.replace("matrix-rigid", "matrix-rigit"), "did you mean", ["-o", "out"]),
        (SWEEP.replace("count = 3", "count = 1000000000"), "1,000,000,000 points", ["-o", "out"]),
        (SWEEP + "[columns]", "is not valid TOML", ["-o", "out"]),
        ("axis = 3\nscenario = 'matrix-rigid'", "write each axis as a table", ["-o", "out"]),
        ("scenario = 'matrix-rigid'\n[[axis]]\nkeys = 3\nvalues = [1]", "give key, or keys", ["-o", "out"]),
    ],
)
def test_bad_input_is_one_line_and_nothing_is_written(
    text: str, words: str, options: list[str], tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    Path("s.toml").write_text(text)
    outcome = nospill("sweep", "s.toml", *options)
    assert outcome.exit_code == 2 and words in outcome.stderr and len(outcome.stderr.strip().splitlines()) == 1
    assert {path.name for path in tmp_path.iterdir()} == {"s.toml"}
