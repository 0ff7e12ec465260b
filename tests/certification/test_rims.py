"""How far below its rim every liquid stays: figures and words."""

from __future__ import annotations

from dataclasses import replace

import pytest

from nospill.certification.rims import RimDistance, rim_distances, rim_line
from nospill.certification.verdict import Row
from nospill.scenario import read_scenario
from nospill.scene.containers.leaning import Edge, edge_of_plane


def height(subject: str, crest: float) -> Row:
    return Row("slosh height", subject, "m", 0.02, crest, 0.02 - crest, 0.5, crest <= 0.02)


def test_the_fullest_row_of_every_liquid_the_nearest_first() -> None:
    scene = read_scenario("soup-and-wine")
    liquids = [item for item in scene.cargo if item.filling is not None]
    rows = [height(item.name, crest) for item in liquids for crest in (0.004, 0.008)]
    found = rim_distances(scene, [*rows, replace(rows[0], constraint="slip", worst_value=9.0)])
    assert sorted(item.subject for item in found) == sorted(item.name for item in liquids)
    assert [item.left for item in found] == sorted(item.left for item in found)
    for item in liquids:
        assert item.filling is not None
        more = item.tolerance.liquid_height if item.tolerance is not None else 0.0
        expected = edge_of_plane(item.container, item.filling.liquid_height + more, 0.008)
        assert next(one.edge for one in found if one.subject == item.name) == expected
    assert rim_distances(scene, []) == () and rim_line(()) == ""


@pytest.mark.parametrize(
    ("below", "along", "words"),
    [
        (0.00629, 0.00629, "6.2 mm"),
        (0.0362, 0.0362, "36.2 mm"),  # not 36.1 by rounding
        (0.00629, 0.0071, "6.2 mm (7.1 along the wall)"),
        (-0.0003, -0.0003, "0.3 mm over it"),
    ],
)
def test_words(below: float, along: float, words: str) -> None:
    assert RimDistance("c1", Edge(0.1, below, along)).words == words


def test_line() -> None:
    edges = [Edge(0.1, 0.001 * number, 0.001 * number) for number in (-1, 2, 3, 4, 5, 6)]
    line = rim_line(tuple(RimDistance(f"c{index}", edge) for index, edge in enumerate(edges)))
    assert line == "below the rim: c0 1.0 mm over it, c1 2.0 mm, c2 3.0 mm, c3 4.0 mm and 2 more"
