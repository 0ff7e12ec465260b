"""Names without what all of them share, so that what tells them apart is read first and never cut away."""

from __future__ import annotations

from collections.abc import Sequence


def short_names(names: Sequence[str]) -> list[str]:
    """Names without the words at their ends, then at their beginnings, that all of them share.

    Words are what underscores separate: shoulder_pan_joint and wrist_1_joint become shoulder_pan and wrist_1,
    fr3_joint1 and fr3_joint2 become joint1 and joint2. One word is left at least, and no name begins with a digit where
    it did not before: joint_1 and joint_2 stay as they are.

    Args:
        names: in any order; a single one, or none, stays as it is.
    """
    words = [name.split("_") for name in names]
    if len(words) < 2:
        return list(names)
    while _all_have(words, -1):
        words = [parts[:-1] for parts in words]
    while _all_have(words, 0) and not any(parts[1][:1].isdigit() for parts in words):
        words = [parts[1:] for parts in words]
    return ["_".join(parts) for parts in words]


def _all_have(words: Sequence[Sequence[str]], place: int) -> bool:
    """Whether all have the same word at one of their ends, and another word besides that is not empty."""
    rest = -2 if place == -1 else 1
    return all(len(own) > 1 and own[rest] for own in words) and len({own[place] for own in words}) == 1


def cut(name: str, longest: int) -> str:
    """A name of at most `longest` letters: one that is longer has its middle left out."""
    if len(name) <= longest:
        return name
    head = (longest - 1) * 2 // 3
    return f"{name[:head]}…{name[len(name) - (longest - 1 - head) :]}"


def cut_apart(names: Sequence[str], longest: int) -> list[str]:
    """Short names of at most `longest` letters that differ wherever the names do.

    Where cutting makes two of them alike, their numbers in the list take the place of their ends.
    """
    short = [cut(name, longest) for name in short_names(names)]
    return [
        text if short.count(text) == 1 else f"{names[index][: longest - 1 - len(str(index + 1))]}…{index + 1}"
        for index, text in enumerate(short)
    ]
