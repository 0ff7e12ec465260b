"""Figures of nearest distances and of the swept volume: what they show, and that they need obstacles."""

from __future__ import annotations

from dataclasses import replace

import matplotlib
import numpy as np
import pytest

from nospill.certification.certificate import judge
from nospill.collisions.over_time import nearest_over_time
from nospill.path_search.branches import free_paths
from nospill.plans.plan import Plan
from nospill.plans.records import PlanningReport, motion_maxima
from nospill.plots.distances import distances_figure
from nospill.plots.evidence import Evidence
from nospill.plots.style import LOOK
from nospill.plots.swept_volume import swept_volume_figure
from nospill.scene.scene import Scene
from nospill.transcription.starting_motions import Start
from tests.builders import joint_paths_of, smooth_record


@pytest.fixture(scope="module")
def evidence(changed_scene) -> Evidence:
    """Two cups past a column and a ball below the tray, slowly."""
    ball = {"name": "ball", "shape": "sphere", "at": ["0.3 m", "0 m", "0.1 m"], "radius": "20 mm"}
    scene = changed_scene("cups-past-a-column", {"planning.slosh_modes": 1})
    scene = changed_scene("cups-past-a-column", {"planning.slosh_modes": 1, "obstacle": [*obstacles(scene), ball]})
    path = free_paths(scene, joint_paths_of(scene))[0]
    record = smooth_record(scene, path, 100, Start(1.5))
    judgement = judge(record, scene)
    report = PlanningReport.empty()
    plan = Plan(scene, record, judgement.certificate, motion_maxima(judgement, scene), report)
    return Evidence(plan, judgement)


def obstacles(scene: Scene) -> list[dict[str, object]]:
    found = scene.source["obstacle"]
    assert isinstance(found, list)
    return found


def test_a_panel_for_each_obstacle_and_one_for_the_arm(evidence: Evidence) -> None:
    with matplotlib.rc_context(LOOK):
        figure = distances_figure(evidence)
    assert figure is not None
    titles = [axes.get_title(loc="left") for axes in figure.axes]
    assert titles == ["to column", "to table", "to ball", "arm with itself and its load"]
    column = figure.axes[0].get_lines()[0].get_ydata()
    rows = {row.subject: row for row in evidence.judgement.certificate.rows if row.constraint == "clearance"}
    assert 1e3 * rows["tray to column"].worst_value <= np.min(column) + 0.3
    assert np.min(column) == pytest.approx(1e3 * rows["tray to column"].worst_value, rel=0.15)
    assert "tray to column" in figure.axes[0].get_title(loc="right")


def test_none_without_obstacles(evidence: Evidence) -> None:
    bare = replace(evidence.plan.scene, obstacles=())
    assert nearest_over_time(bare, evidence.plan.trajectory.joint_position) == ()
    assert distances_figure(Evidence(replace(evidence.plan, scene=bare), evidence.judgement)) is None


def test_swept_volume_in_two_views(evidence: Evidence) -> None:
    with matplotlib.rc_context(LOOK):
        figure = swept_volume_figure(evidence)
    assert figure is not None
    above, side = figure.axes
    assert [axes.get_title(loc="left") for axes in figure.axes] == ["from above", "from the side"]
    played = evidence.judgement.replay.tray.position
    way, straight = (np.asarray(above.get_lines()[index].get_xydata()) for index in (0, 1))
    assert np.linalg.norm(way[-1] - way[0]) == pytest.approx(np.linalg.norm((played[-1] - played[0])[:2]))
    assert np.allclose(straight, way[[0, -1]])
    assert side.get_lines()[0].get_ydata() == pytest.approx(played[:, 2])
    assert side.get_xlim() == pytest.approx(above.get_xlim())
    assert {text.get_text() for text in above.texts} == {"column", "ball"}
    bare = replace(evidence.plan.scene, obstacles=())
    assert swept_volume_figure(Evidence(replace(evidence.plan, scene=bare), evidence.judgement)) is None
