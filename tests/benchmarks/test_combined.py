"""Scenarios of the campaign with three features at once, and the table of pairs."""

from __future__ import annotations

from itertools import combinations
from typing import Any

import numpy as np
import pytest

from benchmarks.campaign.combined import (
    BACK_AFTER,
    FEATURES,
    FEATURES_EACH,
    NEWER,
    ON_FROM,
    combined_distributions,
    features_of,
    way_back,
)
from benchmarks.campaign.distributions import FIRST_COMBINED, FIRST_WITH_NEWER
from benchmarks.campaign.pairs import pair_table
from benchmarks.campaign.report import false_certificate
from benchmarks.campaign.scenes import Case, draw_case
from nospill.errors import ScenarioError
from nospill.scenario import scene_from_table

FEW = [FIRST_COMBINED + number for number in (1, 7, 9, 10, 11, 12)]
FEW += [FIRST_WITH_NEWER + number for number in range(6)]


@pytest.fixture(scope="module")
def cases() -> list[Case]:
    return [draw_case(seed) for seed in FEW]


def of(table: dict[str, Any]) -> dict[str, Any]:
    return {key: value for key, value in table.items() if key not in (BACK_AFTER, ON_FROM)}


def test_a_seed_is_a_scenario_of_three_features(cases: list[Case]) -> None:
    assert draw_case(FEW[0]) == cases[0]
    for case in cases:
        assert len(features_of(case.seed)) == FEATURES_EACH
        assert case.structure.endswith("; " + ", ".join(features_of(case.seed)))
        try:
            scene = scene_from_table(of(case.table), name="read")
        except ScenarioError as error:
            assert "\n" not in str(error) and " together" in str(error)
        else:
            assert len(scene.obstacles) == ("obstacle" in features_of(case.seed))


def test_every_pair_of_features_is_drawn_among_the_first_seeds() -> None:
    drawn = {pair for seed in range(400) for pair in combinations(features_of(FIRST_COMBINED + seed), 2)}
    assert drawn == set(combinations(FEATURES, 2))
    newer = [features_of(FIRST_WITH_NEWER + seed) for seed in range(900)]
    assert all(set(names) & set(NEWER) for names in newer)
    pairs = {pair for pair in combinations((*FEATURES, *NEWER), 2) if set(pair) & set(NEWER)}
    assert pairs <= {pair for names in newer for pair in combinations(names, 2)}


def test_shapes_of_objects_are_those_of_the_features() -> None:
    seeds = [seed for seed in range(FIRST_COMBINED, FIRST_COMBINED + 40) if "carrier" in features_of(seed)]
    assert seeds and all("rack" in combined_distributions(seed).kind.values for seed in seeds)
    others = [seed for seed in range(FIRST_COMBINED, FIRST_COMBINED + 40) if "carrier" not in features_of(seed)]
    assert others and not any("rack" in combined_distributions(seed).kind.values for seed in others)


def test_way_back_is_the_path_reversed(cases: list[Case]) -> None:
    s = np.linspace(0.0, 1.0, 7)
    for case in cases:
        there, back = (scene_from_table(table, name="x").path for table in (of(case.table), way_back(case.table)))
        np.testing.assert_allclose(back.at(1.0 - s), there.at(s), atol=2e-4)


def line(seed: int, kind: str, *features: str, reason: str = "") -> dict[str, Any]:
    return {"seed": seed, "kind": kind, "structure": f"ur5e, line; {', '.join(features)}", "reason": reason}


def test_table_counts_what_ended_how_pair_by_pair() -> None:
    cases = [
        line(1, "planned", "vessel", "carrier", "obstacle"),
        line(2, "not found", "vessel", "carrier", "controller"),
        line(
            3,
            "refused",
            "speed range",
            "duration",
            "obstacle",
            reason="x: speed_range and duration are stated together; leave one out",
        ),
        line(4, "refused", "vessel", "carrier", "approach", reason="path: the arm cannot stand where it starts"),
    ]
    text = list(pair_table(cases))
    carrier = next(row for row in text if row.startswith("| carrier |"))
    assert carrier.split(" | ")[1] == "1/2"
    duration = next(row for row in text if row.startswith("| duration |"))
    assert duration.split(" | ")[1 + list(FEATURES).index("speed range")] == "r"
    assert any(
        row.startswith("| speed_range and duration are stated together | 1 |") and "| 3 |" in row for row in text
    )


def test_a_jump_between_two_motions_is_a_false_certificate() -> None:
    good = {"kind": "planned", "fine": {"ok": True}, "verify": {"ok": True}}
    assert not false_certificate(good) and not false_certificate(good | {"next": good | {"seam": ""}})
    assert false_certificate(good | {"next": good | {"seam": "the arm stands otherwise"}})
    assert false_certificate(good | {"next": good | {"fine": {"ok": False}}})
    assert not false_certificate(good | {"next": {"kind": "refused"}})
