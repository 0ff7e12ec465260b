"""Names without what all of them share, and cut so that they stay apart."""

from __future__ import annotations

import pytest

from nospill.core.short_names import cut, cut_apart, short_names

UR = [
    "shoulder_pan_joint",
    "shoulder_lift_joint",
    "elbow_joint",
    "wrist_1_joint",
    "wrist_2_joint",
    "wrist_3_joint",
]


@pytest.mark.parametrize(
    ("names", "shown"),
    [
        (UR, ["shoulder_pan", "shoulder_lift", "elbow", "wrist_1", "wrist_2", "wrist_3"]),
        (["joint_1", "joint_2"], ["joint_1", "joint_2"]),
        (["fr3_joint1", "fr3_joint2"], ["joint1", "joint2"]),
        (["joint_a1", "joint_a2"], ["a1", "a2"]),
        (["left_arm_joint", "arm_joint", "joint"], ["left_arm_joint", "arm_joint", "joint"]),
        (["a_b_c", "d_b_c"], ["a", "d"]),
        (["only_joint"], ["only_joint"]),
        (["_a", "_b"], ["a", "b"]),
        (["joint_", "arm_"], ["joint", "arm"]),
        ([], []),
    ],
)
def test_what_all_share_is_left_out(names: list[str], shown: list[str]) -> None:
    assert short_names(names) == shown


def test_cut_leaves_both_ends() -> None:
    assert cut("abcdefghij", 10) == "abcdefghij"
    assert cut("abcdefghijk", 8) == "abcd…ijk"


@pytest.mark.parametrize("longest", [6, 8, 10, 14])
def test_cut_names_stay_apart_and_short(longest: int) -> None:
    names = [*UR, *(f"a-long-name-of-cup-{letter}-on-the-tray" for letter in "abcdefg")]
    short = cut_apart(names, longest)
    assert len(set(short)) == len(names)
    assert max(map(len, short)) <= longest


def test_names_of_an_arm_are_not_cut_where_they_fit() -> None:
    assert cut_apart(UR, 14) == short_names(UR)
