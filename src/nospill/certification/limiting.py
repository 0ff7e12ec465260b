"""Which limits hold a motion back, and when: use over time of every limit that the motion comes near."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from nospill.certification.certificate import Judgement
from nospill.core.short_names import short_names
from nospill.laws.constraints import BY_NAME
from nospill.laws.constraints.base import ALL, Role, RowId
from nospill.laws.constraints.clearance import Clearance
from nospill.scene.scene import Scene

NEAR = 0.9
"""Use above which a limit is one that the motion comes near."""
AT_LIMIT = 0.985
"""Use from which the motion is at a limit: what the back-off leaves free of it is less than the rest."""
NAMED = 3
"""Limits that a sentence names."""
_LEAST_SAVED = 5e-4
"""s; less is not spoken of."""
_LEAST_SHARE = 0.005
_ANGLES = {"theta_x": "about x", "theta_y": "about y"}


@dataclass(frozen=True, slots=True)
class Limiting:
    """A limit that the motion comes near.

    Attributes:
        row: constraint and subject.
        t: (m,) from 0 to the end of the motion, s.
        use: (m,) of the limit; the largest over the tolerances of the object.
        share: part of the time for which it is at the limit.
    """

    row: RowId
    t: np.ndarray
    use: np.ndarray
    share: float

    @property
    def at_limit(self) -> np.ndarray:
        """(m,) whether the motion is at the limit."""
        return self.use >= AT_LIMIT


def limiting_rows(judgement: Judgement, scene: Scene) -> tuple[Limiting, ...]:
    """Every limit over time that the motion comes near, the one that holds it longest first.

    Limits of a single instant, such as the residual height, are left out, and the holds with them; so are distances of
    bodies where the path fixes all joints: no slower or faster motion has others.
    """
    played = judgement.replay.t
    t = played[(played >= 0.0) & (played <= judgement.end_time)]
    limiting = []
    for trace in judgement.traces:
        if len(trace.t) < 2 or (trace.constraint == Clearance.name and scene.leaves_time_alone):
            continue
        row = trace.id
        if row not in judgement.corner_use and np.max(trace.use) < NEAR:
            continue
        use = np.interp(t, trace.t, trace.use)
        if row in judgement.corner_use:
            use = np.maximum(use, np.interp(t, played, judgement.corner_use[row]))
        if np.max(use) >= NEAR:
            limiting.append(Limiting(row, t, use, float(np.mean(use >= AT_LIMIT))))
    return tuple(sorted(limiting, key=lambda item: (-item.share, -float(np.max(item.use)))))


def share_without_limit(rows: Sequence[Limiting]) -> float:
    """Part of the time for which the motion is at none of the limits; 1 where there are none."""
    return 1.0 - float(np.mean(np.any([item.at_limit for item in rows], axis=0))) if rows else 1.0


def limiting_names(rows: Sequence[RowId], joints: Sequence[str]) -> list[str]:
    """Rows in plain words: "liquid of c1", "friction of c1", "speed of joint 1".

    Args:
        rows: constraint and subject of each.
        joints: of the robot, so that their names can be shortened alike.
    """
    short = {joint: name.replace("_", " ") for joint, name in zip(joints, short_names(joints), strict=True)}
    names = []
    for row in rows:
        known = BY_NAME.get(row.constraint)
        plain = (known.in_words if known is not None else "") or f"{row.constraint} of {{subject}}"
        everything = "both angles" if known is not None and known.role is Role.TRAY else "all objects"
        names.append(plain.format(subject={**short, **_ANGLES, ALL: everything}.get(row.subject, row.subject)))
    return names


def limiting_text(time_at_limit: Mapping[str, float], joints: Sequence[str]) -> str:
    """What holds the motion back, in one sentence without a full stop; empty where nothing does.

    Args:
        time_at_limit: part of the motion's time at the limit, by label of the row.
        joints: of the robot.
    """
    rows = longest_held(time_at_limit)
    if not rows:
        return ""
    words = limiting_names(rows, joints)
    first, *others = (f"{100 * time_at_limit[row.label]:.0f} %" for row in rows)
    return ", ".join(
        [f"{words[0]} is at its limit for {first} of the time"]
        + [f"{name} for {share}" for name, share in zip(words[1:], others, strict=True)]
    )


def longest_held(time_at_limit: Mapping[str, float]) -> list[RowId]:
    """The limits that the sentence on a motion names, the one that holds it longest first."""
    longest = sorted(time_at_limit.items(), key=lambda item: -item[1])[:NAMED]
    return [RowId.of(label) for label, share in longest if share >= _LEAST_SHARE]


def savings_text(savings: Mapping[str, float], joints: Sequence[str]) -> str:
    """What limits wider by a tenth would save, in one sentence without a full stop; empty where nothing does.

    Args:
        savings: s, by label of the row.
        joints: of the robot.
    """
    named = [(RowId.of(label), saved) for label, saved in sorted(savings.items(), key=lambda item: -item[1])]
    named = [(row, saved) for row, saved in named if saved >= _LEAST_SAVED]
    if not named:
        return ""
    words = limiting_names([row for row, _ in named], joints)
    parts = [f"{saved:.2g} s ({name})" for name, (_, saved) in zip(words, named, strict=True)]
    return f"a limit wider by 10 % would save about {', '.join(parts)}"
