"""Motion files that were damaged by chance: judged as they say or refused in a line, and no false certificate."""

from __future__ import annotations

import json
import random
from collections import Counter
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
import yaml

import nospill as ns

ALPHABET = [*"0123456789.-+eE:[]{},\n \"'#&*!|>%@`\t\x00é", "nan", ".inf", "1e400", "null", "sec", "positions", "- "]
FILES = 30
"""Of the suite; a thousand were run once (docs/reliability.md)."""


def written(t: np.ndarray, q: np.ndarray, v: np.ndarray, joints: tuple[str, ...]) -> dict[str, str]:
    """The same points as a message, as arrays and as a table."""
    points = [
        {
            "positions": at.tolist(),
            "velocities": speed.tolist(),
            "time_from_start": {"sec": int(now), "nanosec": round(1e9 * (now % 1.0))},
        }
        for now, at, speed in zip(t.tolist(), q.round(5), v.round(4), strict=True)
    ]
    rows = [
        ",".join(["t_s", *joints]),
        *(",".join(map(repr, row)) for row in np.column_stack([t, q]).round(5).tolist()),
    ]
    arrays = {"joint_names": list(joints), "t": t.tolist(), "q": q.round(5).tolist(), "qd": v.round(4).tolist()}
    return {
        "yaml": yaml.safe_dump({"joint_names": list(joints), "points": points}),
        "json": json.dumps(arrays),
        "csv": "\n".join(rows) + "\n",
    }


def damaged(text: str, draw: random.Random) -> str:
    """One to three pieces replaced by others."""
    for _ in range(draw.randint(1, 3)):
        first = draw.randint(0, len(text))
        last = min(len(text), first + draw.choice([0, 0, 1, 1, 2, 10, 40]))
        piece = "".join(draw.choice(ALPHABET) for _ in range(draw.randint(0, 3)))
        text = text[:first] + piece + text[last:]
    return text


def judge_damaged(plan: ns.Plan, folder: Path, files: int) -> Counter[str]:
    """How many damaged files were certified, not certified and refused; of those certified a look at 8 kHz."""
    motion, found = plan.trajectory.motion, Counter[str]()
    t = np.linspace(0.0, plan.duration, 21)
    q, v = motion(t), motion(t, 1)
    v[[0, -1]] = 0.0
    forms = written(t, q, v, plan.scene.robot.joints)
    for ending, text in forms.items():
        (folder / f"whole.{ending}").write_text(text, encoding="utf-8")
        assert ns.judge(folder / f"whole.{ending}", plan.scene).certificate.ok
    for seed in range(files):
        ending = ("yaml", "json", "csv")[seed % 3]
        place = folder / f"damaged.{ending}"
        place.write_text(damaged(forms[ending], random.Random(seed)), encoding="utf-8")
        try:
            judged = ns.judge(place, plan.scene)
        except ns.NospillError as error:
            assert "\n" not in str(error), (seed, str(error))
            found["refused"] += 1
            continue
        found[judged.certificate.word] += 1
        if judged.certificate.ok:
            assert ns.judge(place, plan.scene, rate=8000.0).certificate.ok, seed
    return found


def test_damaged_files_are_judged_or_refused(gentle_plan: Callable[..., ns.Plan], tmp_path: Path) -> None:
    found = judge_damaged(gentle_plan("pp-two-cups", 1), tmp_path, FILES)
    assert found.total() == FILES and found["refused"] > FILES / 4


@pytest.mark.parametrize("seed", [0, 1])
def test_the_damage_is_the_same_every_time(seed: int) -> None:
    text = "positions: [0.1, 0.2]\n"
    assert damaged(text, random.Random(seed)) == damaged(text, random.Random(seed)) != text
