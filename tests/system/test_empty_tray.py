"""A tray with nothing on it, as on the way back: planned, judged, kept and shown by its arm's limits alone."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

import nospill as ns
from nospill.margins import margins
from nospill.verify import verify
from tests.cli.commands import nospill
from tests.system.test_paths_of_joints import CUP, moved, table

_WAY, _ACCELERATION = 1.2, 5.0
"""rad of the last joint, rad/s^2."""


@pytest.fixture(scope="module")
def empty() -> ns.Plan:
    own = table(moved({5: _WAY}))
    del own["cargo"]
    return ns.plan(ns.load(own))


def test_the_arm_alone_says_how_long_it_takes(empty: ns.Plan) -> None:
    """From rest to rest with acceleration a over L: 2 sqrt(L/a)."""
    least = 2.0 * np.sqrt(_WAY / _ACCELERATION)
    assert empty.certificate.ok and "empty tray" in [item.name for item in empty.warnings]
    assert least * (1 - 1e-3) < empty.duration < 1.035 * least  # jerks are limited, and back-off is kept
    assert ns.certify(empty.trajectory, empty.scene, rate=8000.0).ok
    kept = {row.constraint for row in empty.certificate.rows}
    assert "joint acceleration" in kept and not kept & {"slip", "tip", "lift", "slosh height"}


def test_a_cup_on_it_takes_longer(empty: ns.Plan) -> None:
    full = empty.scene.changed({"cargo.c": {**CUP, "at": ["60 mm", "0 mm"]}})
    assert [item.name for item in full.cargo] == ["c"]
    assert ns.plan(full).duration > empty.duration
    assert full.changed({"cargo.c": None}).source == empty.scene.source


def test_its_figures_are_those_that_apply(empty: ns.Plan) -> None:
    drawn = []
    for name in empty.plots:
        try:
            drawn.append(empty.plot(name) and name)
        except ns.ScenarioError as error:
            assert "does not apply" in str(error)
    assert set(drawn) == {"limits", "joints", "summary", "tray", "path"}


def test_what_needs_an_object_says_so(empty: ns.Plan) -> None:
    with pytest.raises(ns.ScenarioError, match="nothing stands on the tray, so no number of an object can be off"):
        margins(empty)
    report = verify(empty)
    assert report.ok and report.message == "Nothing stands on the tray that could move."


def test_the_folder_goes_through_every_command(empty: ns.Plan, tmp_path: Path) -> None:
    folder = tmp_path / "empty"
    empty.save(folder)
    assert nospill("check", str(folder)).exit_code == 0
    page = tmp_path / "page.html"
    assert nospill("report", str(folder), "-o", str(page)).exit_code == 0
    assert "UR5e moves an empty tray." in page.read_text()
    assert nospill("view", str(folder), "--html", str(tmp_path / "view.html")).exit_code == 0
    csv = tmp_path / "joints.csv"
    assert nospill("export", str(folder), "--format", "csv", "-o", str(csv)).exit_code == 0
    judged = nospill("judge", str(csv), "--scenario", str(folder))
    assert judged.exit_code == 0, judged.output
    result = nospill("margins", str(folder))
    assert result.exit_code == 2 and "nothing stands on the tray" in result.stderr
