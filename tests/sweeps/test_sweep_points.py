"""Points: keys by content, groups of neighbours."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from hypothesis import given
from hypothesis import strategies as st

from nospill.sweeps.axes import axes_of, grid
from nospill.sweeps.points import GROUP, Line, Point, grouped, point_of


def points(axes: Mapping[str, Sequence[object]]) -> list[Point]:
    return [point_of("base", values) for values in grid(axes_of(axes))]


def test_a_key_is_of_the_content_and_of_nothing_else() -> None:
    first = point_of("base", {"a": 1, "b": "2 mm"})
    assert first.key == point_of("base", {"b": "2 mm", "a": 1}).key
    assert len({first.key, point_of("other", first.values).key, point_of("base", {"a": 2, "b": "2 mm"}).key}) == 3
    assert first.key == "5b49f34941e55060"  # a file of another day and machine has it


@given(st.integers(1, 30), st.integers(1, 9), st.sampled_from([["x"], ["x", "y"], [0.1, 0.2, 0.3]]))
def test_groups_hold_every_point_once(count: int, others: int, words: list[object]) -> None:
    axes = {"a": list(range(count)), "b": [f"{n} mm" for n in range(others)], "c": words}
    every = points(axes)
    groups = grouped(every, axes_of(axes))
    assert sorted(point.key for group in groups for point in group.points) == sorted(point.key for point in every)
    for group in groups:
        assert group.head == group.points[0] and 1 <= len(group.points) <= GROUP
        if isinstance(words[0], str):  # a word is no neighbour of another one
            assert len({point.values["c"] for point in group.points}) == 1


def test_a_group_is_of_neighbours_and_its_head_in_the_middle() -> None:
    axes = {"a": [float(n) for n in range(16)]}
    first, second = grouped(points(axes), axes_of(axes))
    assert {point.values["a"] for point in first.points} == set(range(8))
    assert first.head is not None and first.head.values["a"] in (3.0, 4.0)
    assert second.head is not None and second.head.values["a"] in (11.0, 12.0)
    assert grouped([], ()) == []


def test_a_line_comes_back_from_its_file() -> None:
    line = Line("k", {"a": "1 mm"}, "planned", figures={"duration_s": 1.5}, warm_from="h")
    assert Line.from_dict(line.to_dict()) == line and line.certified
