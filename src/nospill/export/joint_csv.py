"""A table of the joints for any number of them: time, positions, and for most programs speeds and accelerations.

Two comments, a header, one row a sample, separated by commas. Rate, unit, names and columns are those of whoever reads
it: one profile each, all in one table.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from nospill.core.files import atomic_text
from nospill.errors import PlanFolderError, ScenarioError
from nospill.export.base import (
    Exporter,
    checked_samples,
    finite_row,
    full_columns,
    number,
    numbers,
    require_joints,
    text_of,
)
from nospill.export.profiles import PLAIN, PROFILES, Profile, profile_named
from nospill.motion.interpolation import JointSamples
from nospill.scene.scene import Scene


def _write(samples: JointSamples, scene: Scene, path: Path, profile: Profile) -> None:
    reason = profile.reason_against(scene, samples.rate)
    if reason is not None:
        raise ScenarioError(reason)
    columns = [samples.position, *(full_columns(samples) if profile.whole else ())]
    if profile.unit == "deg":
        columns = [np.degrees(column) for column in columns]
    unit = profile.unit
    units = f"positions in {unit}" + (f", speeds in {unit}/s, accelerations in {unit}/s^2" if profile.whole else "")
    lines = [
        f"# joints {', '.join(scene.robot.joints)} of {scene.robot.name}, written by nospill",
        f"# t in s, {units}; {number(round(samples.rate, 3))} rows a second; read by {profile.title}",
        ",".join(profile.columns(scene)),
        *(numbers(row, ",") for row in np.column_stack([samples.t, *columns])),
    ]
    atomic_text(path, "\n".join([*lines, ""]))


def _read(path: Path, scene: Scene, profile: Profile) -> JointSamples:
    """The rows; the header says for which reader they are, this one first: names and units say everything."""
    lines = [(count, line.strip()) for count, line in enumerate(text_of(path).splitlines(), 1)]
    named = [line for _, line in lines if line.startswith("# joints ")]
    rows = [(count, line) for count, line in lines if line and not line.startswith("#")]
    header = rows[0][1].split(",") if rows else []
    # a profile has names of its own, the comment those of the arm
    stated = named[0].removeprefix("# joints ").partition(" of ")[0].split(", ") if named else None
    require_joints(stated, scene, path)
    written = next((item for item in (profile, *PROFILES.values()) if item.columns(scene) == header), None)
    if written is None:
        wanted = ",".join(profile.columns(scene))
        raise PlanFolderError(f"{path}: its header is {','.join(header)[:80]!r}, not that of a profile: {wanted[:120]}")
    table = np.array([finite_row(line.split(","), len(header), f"{path}, line {count}") for count, line in rows[1:]])
    blocks = np.split(table.reshape(-1, len(header))[:, 1:], 3 if written.whole else 1, axis=1)
    if written.unit == "deg":
        blocks = [np.radians(block) for block in blocks]
    return checked_samples(JointSamples(table.reshape(-1, len(header))[:, 0], *blocks), path)


def csv_exporter(profile: str = PLAIN.name) -> Exporter:
    """The table for one reader.

    Raises:
        ScenarioError: no such profile.
    """
    chosen = profile_named(profile)
    return Exporter(
        name="csv",
        suffixes=(".joints.csv",),
        title="table of any number of joints: time, positions, speeds, accelerations; --profile for who reads it",
        receiver=f"{chosen.title} ({chosen.interpolation.name})",
        interpolation=chosen.interpolation,
        reason_against=chosen.reason_against,
        write=lambda samples, scene, path: _write(samples, scene, path, chosen),
        read=lambda path, scene: _read(path, scene, chosen),
        caution=lambda scene, rate: chosen.caution(scene),
        usual_rate=chosen.rates[0] if chosen.rates else None,
        uneven=chosen.whole,
        options=("profile",),
        with_options=csv_exporter,
    )


CSV = csv_exporter()
"""The table with everything in it."""
