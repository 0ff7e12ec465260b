"""One smooth motion with mixed cargo, judged and saved; no solver is involved, so some limits fail."""

from __future__ import annotations

import shutil
from dataclasses import replace
from pathlib import Path

import pytest

from nospill.certification.certificate import judge
from nospill.plans.plan import Plan
from nospill.plans.records import PlanningReport, Starts, motion_maxima
from nospill.report import Report, make_report
from nospill.scenario import scene_from_table
from nospill.transcription.starting_motions import Start
from tests.builders import joint_path_of, smooth_record, with_few_speeds

HOSTILE = "<script>alert('1')</script> & \"50 %\" $x$ <img src=http://example.org/a.png> \u6c34"

TABLE: dict[str, object] = {
    "fidelity": "deliverable",
    "name": "small-plan",
    "description": HOSTILE,
    "robot": {"model": "comau-smart-six"},
    "tray": {"size": ["335 mm", "250 mm"], "friction": 0.466, "friction_reserve": 0.1, "offset": "108 mm"},
    "cargo": [
        {
            "name": "cup",
            "at": ["-100 mm", "-60 mm"],
            "shape": "cylinder",
            "radius": "25 mm",
            "height": "99 mm",
            "liquid": "water",
            "liquid_height": "49 mm",
            "max_slosh_height": "12 mm",
        },
        {
            "name": "block",
            "at": ["70 mm", "40 mm"],
            "yaw": "30 deg",
            "shape": "box",
            "length": "80 mm",
            "width": "40 mm",
            "height": "60 mm",
            "mass": "0.3 kg",
        },
    ],
    "path": {"type": "preset", "name": "arc", "yaw": ["0 deg", "90 deg"]},
    "motion": {"end": "residual"},
}


def smooth_plan(stretch: float) -> Plan:
    """A quintic motion along the path: the longer the `stretch`, the gentler."""
    scene = scene_from_table(TABLE, name="x")
    path = joint_path_of(scene)
    trajectory = smooth_record(scene, path, 200, Start(stretch=stretch, skew=0.2))
    judgement = judge(trajectory, scene)
    effort = PlanningReport(1.5, 0.5, 10, 1, Starts(3, 2, 2, (1.0, 1.1)), {"solve": 0.5}, "none", {"slip | cup": 0.01})
    maxima = motion_maxima(judgement, scene)
    return with_few_speeds(Plan(scene, trajectory, judgement.certificate, maxima, effort, judgement))


@pytest.fixture(scope="session")
def fast_plan() -> Plan:
    found = smooth_plan(0.5)
    assert not found.certificate.ok
    return found


@pytest.fixture(scope="session")
def slow_plan() -> Plan:
    found = smooth_plan(1.2)
    assert found.certificate.ok, found.message
    return found


@pytest.fixture(scope="session")
def hostile_plan(slow_plan: Plan) -> Plan:
    """A robot whose title is markup, as a file of somebody else's may have it."""
    scene = replace(slow_plan.scene, robot=replace(slow_plan.scene.robot, title=HOSTILE))
    return replace(slow_plan, scene=scene)


@pytest.fixture(scope="session")
def fast_report(fast_plan: Plan) -> Report:
    return make_report(fast_plan)


@pytest.fixture(scope="session")
def slow_report(slow_plan: Plan) -> Report:
    return make_report(slow_plan)


@pytest.fixture(scope="session")
def saved_once(slow_plan: Plan, tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Its folder, not to be written to."""
    place = tmp_path_factory.mktemp("saved") / "out"
    slow_plan.save(place)
    return place


@pytest.fixture
def folder(saved_once: Path, tmp_path: Path) -> Path:
    """A plan folder."""
    return Path(shutil.copytree(saved_once, tmp_path / "out"))
