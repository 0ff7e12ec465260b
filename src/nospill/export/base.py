"""What an exporter is: one robot controller's file format, written and read back."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from nospill.errors import PlanFolderError
from nospill.motion.interpolation import Interpolation, JointSamples
from nospill.scene.scene import Scene


@dataclass(frozen=True, slots=True)
class Exporter:
    """One file format for robot controllers. Exporters format the samples; they never resample.

    Attributes:
        name: key in the table of exporters.
        suffixes: ends of the file names that `write` takes, the usual one first; each has its own spelling of the
            format where there are several.
        title: what the format is, in one line.
        receiver: what plays the file, and how it moves between the samples, in one line.
        interpolation: the same as the judge plays it.
        reason_against: the sentence that says why a scene cannot be written in this format at a rate in Hz, or None
            when it can.
        write: (samples, scene, path) -> file; raises ScenarioError with that sentence, PlanFolderError for the disk.
        read: (path, scene) -> samples from t = 0 as the receiver takes them from the file; raises PlanFolderError for
            a file that is missing, not in this format or not for this scene's robot.
        plan_file: name under which every plan folder holds this file as well, or None.
        caution: the sentence about receivers that play a file of this scene at this rate in Hz otherwise, or None.
        usual_rate: Hz, at which it is written where no rate is asked for; None for the plan's.
        uneven: whether its receiver takes points that are not evenly spaced.
        one_payload: whether a file states the load on the flange, once for all of it.
        options: names of what can be chosen about the format, as the command line has them.
        with_options: (those of them that are chosen) -> the format; raises ScenarioError for a value that is none.
        beginning: (s after the start of a plan) -> the format for a motion that goes on from the plan then, where its
            files have a place for that.
    """

    name: str
    suffixes: tuple[str, ...]
    title: str
    receiver: str
    interpolation: Interpolation
    reason_against: Callable[[Scene, float], str | None]
    write: Callable[[JointSamples, Scene, Path], None]
    read: Callable[[Path, Scene], JointSamples]
    plan_file: str | None = None
    caution: Callable[[Scene, float], str | None] = lambda scene, rate: None
    usual_rate: float | None = None
    uneven: bool = False
    one_payload: bool = False
    options: tuple[str, ...] = ()
    with_options: Callable[..., Exporter] | None = None
    beginning: Callable[[float], Exporter] | None = None


def full_columns(samples: JointSamples) -> tuple[np.ndarray, np.ndarray]:
    """Speeds and accelerations of samples that have both.

    Raises:
        PlanFolderError: they have not.
    """
    if samples.speed is None or samples.acceleration is None:
        raise PlanFolderError("this format needs speeds and accelerations; these samples have positions only")
    return samples.speed, samples.acceleration


def number(value: float) -> str:
    """Shortest text that reads back as exactly this number, a number to JSON and to YAML 1.1 (1.0e-05, not 1e-05)."""
    text = repr(float(value) + 0.0)  # turns -0.0 into 0.0
    mantissa, exponent, power = text.partition("e")
    return f"{mantissa}.0e{power}" if exponent and "." not in mantissa else text


def numbers(values: np.ndarray, separator: str = ", ") -> str:
    """A row of numbers (n,) as `number` writes them."""
    return separator.join(number(value) for value in values)


def finite_row(cells: object, count: int, where: str) -> list[float]:
    """A row of finite numbers from a file, as text or as numbers.

    Args:
        cells: a list of `count` numbers or texts of numbers; anything else is an error.
        count: how many there must be.
        where: file and place, for the message.

    Raises:
        PlanFolderError: it is not such a row.
    """
    try:
        values = [float(cell) for cell in cells] if isinstance(cells, list) else []
    except (TypeError, ValueError, OverflowError):  # of an integer that no float holds
        values = []
    if len(values) != count or not all(map(math.isfinite, values)):
        raise PlanFolderError(f"{where}: {str(cells)[:80]} is not a row of {count} finite numbers")
    return values


def checked_samples(samples: JointSamples, where: str | Path) -> JointSamples:
    """The samples as they are.

    Raises:
        PlanFolderError: fewer than two, or time does not start at 0 or does not increase.
    """
    if len(samples.t) < 2:
        raise PlanFolderError(f"{where}: holds {len(samples.t)} samples, at least 2 make a motion")
    if samples.t[0] != 0.0:
        raise PlanFolderError(f"{where}: time starts at {samples.t[0]:g} s, 0 is expected")
    backwards = np.flatnonzero(np.diff(samples.t) <= 0.0)
    if len(backwards):
        row = int(backwards[0])
        raise PlanFolderError(f"{where}: time does not increase after sample {row + 1} ({samples.t[row]:g} s)")
    return samples


def require_joints(found: object, scene: Scene, where: str | Path) -> None:
    """Refuse a file whose joints are not the robot's, in its order.

    Raises:
        PlanFolderError: they are not.
    """
    wanted = list(scene.robot.joints)
    if found != wanted:
        shown = ", ".join(map(str, found)) if isinstance(found, list) else repr(found)
        raise PlanFolderError(f"{where}: its joints are {shown[:200]}; those of the robot are {', '.join(wanted)}")


def text_of(path: Path) -> str:
    """The content of a text file (UTF-8).

    Raises:
        PlanFolderError: it cannot be read.
    """
    try:
        return path.read_text(encoding="utf-8-sig")
    except (OSError, UnicodeDecodeError) as error:
        reason = error.strerror if isinstance(error, OSError) else "not a text file"
        raise PlanFolderError(f"cannot read {path}: {reason}; write it again with nospill export") from error
