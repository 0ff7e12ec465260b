"""A motion that leaves the arm's reach between two nodes: solved again with the determinant of the Jacobian bounded."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import pytest

from nospill.errors import ModelError, NoSolutionError
from nospill.planning import planner, refinement
from nospill.planning.log import Log
from nospill.robots.kinematics.regularity import clearance
from nospill.scenario import read_scenario
from nospill.transcription.passages import NOT_BOUNDED, Passage, bounded_as, stage_determinants
from nospill.transcription.starting_motions import coarse_start
from tests.builders import joint_path_of


def candidate(name: str) -> Any:
    stages = SimpleNamespace(name=name, duration=1.0, intervals=10)
    scene = SimpleNamespace(motion=SimpleNamespace(speed_range=None), tracking=None)
    task = SimpleNamespace(scene=scene, judged_scene=lambda _: scene)
    return SimpleNamespace(stages=stages, active=SimpleNamespace(task=task, refined=frozenset()))


@pytest.mark.parametrize("bounded", [True, False], ids=["solved with it bounded", "not solved"])
def test_a_motion_out_of_reach_is_solved_again_once(monkeypatch: pytest.MonkeyPatch, bounded: bool) -> None:
    starts: list[str] = []

    def exported(one: Any) -> Any:
        if one.stages.name == "beyond":
            raise ModelError("no joint positions found")
        return SimpleNamespace(slosh=())

    def off_singularities(active: Any, start: Any, log: Log) -> Any:
        starts.append(start.name)
        return candidate("inside") if bounded else None

    monkeypatch.setattr(refinement, "exported", exported)
    monkeypatch.setattr(refinement, "_off_singularities", off_singularities)
    monkeypatch.setattr(
        refinement, "judge_motion", lambda *_, **__: SimpleNamespace(replay=None, traces=None, leaves_margin=False)
    )
    monkeypatch.setattr(refinement, "judged_tracks", lambda *_: ())
    monkeypatch.setattr(refinement, "replace", lambda item, **_: item)
    monkeypatch.setattr(refinement.diagnosis, "not_playable", lambda *_: NoSolutionError("cannot be played"))
    judged: Any = refinement._judge
    start = candidate("before").stages
    if bounded:
        assert judged(candidate("beyond"), Log(None, 60.0), else_from=start).candidate.stages.name == "inside"
    else:
        with pytest.raises(NoSolutionError, match="cannot be played"):
            judged(candidate("beyond"), Log(None, 60.0), else_from=start)
    assert starts == ["before"]
    assert judged(candidate("inside"), Log(None, 60.0)).candidate.stages.name == "inside"


def test_the_bound_is_that_of_the_motion() -> None:
    scene = read_scenario("pp-two-cups")
    motion = coarse_start(scene, joint_path_of(scene, samples=21))
    bounded = bounded_as(NOT_BOUNDED, scene, motion)
    assert bounded == Passage(determinant=clearance(stage_determinants(scene, motion)))
    assert bounded is not None and bounded_as(bounded, scene, motion) is None


@pytest.mark.parametrize("ends", ["certified", "rejected", "not playable", "none found"])
def test_a_motion_that_cannot_be_played_ends_no_search(monkeypatch: pytest.MonkeyPatch, ends: str) -> None:
    """The next candidate is looked at; where there is none, the first failure is told."""

    def certified(one: Any, log: Log) -> Any:
        if one.stages.name == "not playable":
            raise NoSolutionError("cannot be played")
        certificate = SimpleNamespace(ok=one.stages.name == "certified")
        return SimpleNamespace(candidate=one, judgement=SimpleNamespace(certificate=certificate))

    def candidates() -> Any:
        yield searched("not playable")
        if ends == "none found":
            raise NoSolutionError("not found elsewhere")
        yield searched(ends)

    def searched(name: str) -> Any:
        one = candidate(name)
        one.active.task.ignored, one.active.margins = (), {}
        return one

    monkeypatch.setattr(planner, "certify_by_refinement", certified)
    first: Any = planner._first_certified
    if ends in ("certified", "rejected"):
        judged, instead = first(candidates(), Log(None, 60.0))
        assert (judged.candidate.stages.name, instead) == (ends, "")  # no motion on the path in the place of another
    else:
        with pytest.raises(NoSolutionError, match="cannot be played"):
            first(candidates(), Log(None, 60.0))
