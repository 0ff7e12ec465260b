"""Rows as messages name them."""

from __future__ import annotations

import pytest

from nospill.certification.verdict import Row


@pytest.mark.parametrize(
    ("constraint", "subject", "variant", "label"),
    [
        ("clearance", "holder to link_4", "estimated capsules", "holder to link_4 (estimated capsules)"),
        ("clearance", "c1 to column", "", "c1 to column"),
        ("slip", "c1", "fill +2 mm", "c1 at fill +2 mm"),
    ],
)
def test_what_distances_rest_on_stands_in_brackets(constraint: str, subject: str, variant: str, label: str) -> None:
    assert Row(constraint, subject, "m", 0.0, 1.0, 1.0, 0.0, True, variant).label == label
