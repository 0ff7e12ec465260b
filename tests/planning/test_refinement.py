"""How often the fine grid is tried again where the first barrier does not lead there, and which barrier that is."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import pytest

from nospill.planning import refinement
from nospill.planning.log import Log
from nospill.transcription.solvers.options import BARRIERS


@pytest.mark.parametrize(("leads_past", "expected"), [(False, BARRIERS), (True, BARRIERS[:1])])
def test_on_planes_only_the_least_barrier_is_tried(
    monkeypatch: pytest.MonkeyPatch, leads_past: bool, expected: tuple[float, ...]
) -> None:
    tried: list[float] = []
    active: Any = SimpleNamespace(
        scene=None, task=SimpleNamespace(leads_past=leads_past, passage=SimpleNamespace(along=None))
    )
    candidate: Any = SimpleNamespace(active=SimpleNamespace(with_rows=lambda rows: active), stages=None)

    def solved(active: object, start: object, log: Log, options: dict[str, float], *, tightens: bool) -> Any:
        assert not tightens  # no judged motion asks for it
        tried.append(options["barrier_start"])
        return SimpleNamespace(has_converged=False)

    monkeypatch.setattr(refinement, "on_grid", lambda *_: None)
    monkeypatch.setattr(refinement, "solved", solved)
    assert refinement._refine(candidate, 100, (), Log(None, 60.0)) is None
    assert tuple(tried) == expected


@pytest.mark.parametrize(
    ("leaves_path", "slack", "larger_first"), [(False, -2.0, True), (False, -0.6, False), (True, -2.0, False)]
)
def test_from_a_start_that_breaks_a_row_by_its_budget_a_larger_barrier_comes_first(
    monkeypatch: pytest.MonkeyPatch, leaves_path: bool, slack: float, larger_first: bool
) -> None:
    """Off its path the tray's place is held by little, and a larger barrier leads away from it."""
    tried: list[dict[str, float]] = []

    def solved(active: object, start: object, log: Log, options: dict[str, float], *, tightens: bool) -> Any:
        assert tightens and options["max_iterations"] == refinement.REFINE_ITERATIONS
        tried.append(options)
        return SimpleNamespace(has_converged=False)

    monkeypatch.setattr(refinement, "solved", solved)
    monkeypatch.setattr(refinement, "problem_about", lambda *_: None)
    monkeypatch.setattr(refinement, "row_slack", lambda *_: {"residual height | c1": slack, "slip | c1": 0.3})
    scene = SimpleNamespace(motion=SimpleNamespace(leaves_path=leaves_path))
    active: Any = SimpleNamespace(task=SimpleNamespace(scene=scene))
    nothing: Any = None
    assert refinement.solve_from(active, nothing, Log(None, 60.0)) is None
    least, larger, largest = BARRIERS
    barriers = [options.get("barrier_start") for options in tried]
    assert barriers == [*((larger, least, largest) if larger_first else BARRIERS), None]
    if larger_first:
        assert tried[0]["bound_push"] > tried[1]["bound_push"]  # it is moved off the bounds that it stands on


@pytest.mark.parametrize(
    ("members", "other", "known"),
    [
        (3, {}, True),
        (4, {}, True),
        (5, {}, False),
        (3, {"refined": {"c1"}}, False),
        (3, {"modes": 6}, False),
        (3, {"task": object()}, False),
        (3, {"intervals": 102}, False),
    ],
)
def test_members_that_join_are_solved_with_the_multipliers_of_those_there(
    monkeypatch: pytest.MonkeyPatch, members: int, other: dict[str, Any], known: bool
) -> None:
    """Not where more join than there were, or modes do, nor on another grid."""
    given: list[object] = []

    def solved(active: object, start: object, log: Log, options: object, warm: object, *, tightens: bool) -> Any:
        given.append(warm)
        return SimpleNamespace(has_converged=True, keeps_branch=True)

    monkeypatch.setattr(refinement, "solved", solved)
    alike = {"task": None, "refined": set[str](), "modes": 3}
    before: Any = SimpleNamespace(
        active=SimpleNamespace(members=range(2), **alike), stages=SimpleNamespace(intervals=100)
    )
    start: Any = SimpleNamespace(intervals=other.pop("intervals", 100))
    active: Any = SimpleNamespace(members=range(members), **(alike | other))
    found = refinement._with_members(before, active, start, Log(None, 60.0))
    assert (found is not None) == known and given == [before] * known
