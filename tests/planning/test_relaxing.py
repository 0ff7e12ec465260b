"""Back-off that a certified motion shows to be more than is needed."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

import pytest

from nospill.laws.constraints.base import RowId
from nospill.planning import refinement, shortening
from nospill.planning.active_set import ActiveSet
from nospill.planning.candidate import Candidate, solved
from nospill.planning.log import Log
from nospill.planning.next_set import next_set
from nospill.planning.planner import plan
from nospill.planning.refinement import Judged, solve_from, start_from
from nospill.planning.shortening import certify_by_refinement
from nospill.planning.task import Task
from nospill.planning.tightening import relaxed_backoff
from nospill.scene.scene import Scene
from nospill.transcription.sensitivity import saving_of
from nospill.transcription.solvers.options import near_optimum

_TOO_MUCH = 0.08

Begun = tuple[Candidate, float, Log]


def test_most_of_what_is_free_is_no_longer_kept_and_never_less_than_nothing() -> None:
    near, far, full, end, unseen = (
        RowId("slip", "c1"),
        RowId("tip", "c1"),
        RowId("slip", "c2"),
        RowId("residual height", "c1"),
        RowId("twist", "c1"),
    )
    relaxed = relaxed_backoff(
        {near: 0.05, far: 0.004, full: 0.05, end: 0.3, unseen: 0.003}, {near: 0.96, far: 0.5, full: 0.999, end: 0.8}
    )
    assert relaxed == pytest.approx({near: 0.05 - 0.8 * 0.038, far: 0.0, full: 0.05, end: 0.3, unseen: 0.003})


@pytest.fixture
def begun(changed_scene: Callable[..., Scene]) -> Begun:
    """An answer with far too much back-off on heights, and the duration that is found without it."""
    scene = changed_scene("matrix-liquid", {"planning.intervals": 40})
    found = plan(scene)
    log = Log(None, 120.0)
    active = ActiveSet.of(Task.of(scene), found.trajectory.joint_position)
    active = active.with_backoff({row: _TOO_MUCH for row in active.possible if row.constraint == "slosh height"})
    candidate = solve_from(active, start_from(active, found.trajectory, log), log)
    assert candidate is not None
    return candidate, found.duration, log


@pytest.mark.slow
def test_a_motion_with_too_much_back_off_becomes_as_short_as_one_without(begun: Begun) -> None:
    candidate, duration, log = begun
    judged = certify_by_refinement(candidate, log)
    assert judged.judgement.certificate.ok
    assert candidate.stages.duration > 1.01 * duration
    assert judged.trajectory.end_time == pytest.approx(duration, rel=5e-3)


@pytest.mark.slow
def test_what_less_back_off_saves_is_predicted(begun: Begun) -> None:
    candidate, _, log = begun
    before = candidate.active.backoff
    less = {row: value - (2e-3 if row.constraint == "slosh height" else 0.0) for row, value in before.items()}
    again = solved(replace(candidate.active, backoff=less), candidate.stages, log, near_optimum(1e-7, 100), candidate)
    assert again.has_converged
    saved = candidate.solution.objective - again.solution.objective
    assert saved > 1e-4
    assert saving_of(candidate.problem, candidate.solution, less) == pytest.approx(saved, rel=0.1)


@pytest.mark.slow
def test_of_two_motions_only_a_certified_one_counts(begun: Begun, monkeypatch: pytest.MonkeyPatch) -> None:
    candidate, _, log = begun
    refined = refinement.refine_until_certified
    answers: list[Judged] = []

    def broken_the_second_time(candidate: Candidate, log: Log, **limits: float) -> Judged:
        found = refined(candidate, log, **limits)
        verdict = replace(found.judgement.certificate, ok=not answers)
        answers.append(replace(found, judgement=replace(found.judgement, certificate=verdict)))
        return answers[-1]

    monkeypatch.setattr(shortening, "refine_until_certified", broken_the_second_time)
    assert certify_by_refinement(candidate, log) is answers[0]
    assert len(answers) == 2 and answers[1].trajectory.end_time < answers[0].trajectory.end_time


@pytest.mark.slow
def test_a_motion_as_long_as_another_is_not_tightened(begun: Begun) -> None:
    """What breaks its limits by 2 % is certified after some rounds, and given up where it may not take so long."""
    candidate, duration, log = begun
    too_little = {
        row: -0.02 if row.constraint == "slosh height" else kept for row, kept in candidate.active.backoff.items()
    }
    active = replace(candidate.active, backoff=too_little)
    rough = solved(active, candidate.stages, log, near_optimum(1e-5, 100))
    assert rough.has_converged
    before = log.rounds
    given_up = refinement.refine_until_certified(rough, log, below=0.5 * duration)
    assert not given_up.judgement.certificate.ok and given_up.candidate is rough and log.rounds == before
    finished = refinement.refine_until_certified(rough, log, below=2.0 * duration)
    assert finished.judgement.certificate.ok and log.rounds > before
    assert finished.trajectory.end_time > given_up.trajectory.end_time
    promised = refinement._at_least(rough, next_set(rough.active, given_up.judgement, rough.solution.slack))
    assert rough.stages.duration < promised < finished.trajectory.end_time
    rounds = log.rounds
    unsolved = refinement.refine_until_certified(rough, log, below=promised - 1e-6)
    assert unsolved.candidate is rough and log.rounds == rounds
