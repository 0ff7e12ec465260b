"""A URScript program of `servoj` targets for Universal Robots, one each control period.

`servoj` is called with the controller's own period (2 ms on e-Series, 8 ms on CB3), so the controller never moves
between two targets on its own account: each is the reference of exactly one of its cycles, and what happens inside a
cycle is the joint drives' doing. Certified is the quintic spline through the targets, as for any position controller. A
straight line between targets would be a worse model: it has an infinite acceleration at each target, which no drive
follows. How `servoj` filters the targets (`lookahead_time`, `gain`) is not published; it makes the arm lag and rounds
the motion, and no certificate of a file can speak about it. The program therefore asks for the shortest look-ahead.

A program that finds the arm away from the first target stops with a message instead of jumping there.

Two forms. What is sent to the controller by socket, from a client library too, begins with def in the first column and
ends with the line "end", and then runs of itself [Universal Robots, Remote control via TCP/IP; client library, which
refuses anything else]. In a script node of PolyScope the definition does nothing unless the function is called too.
"""

from __future__ import annotations

import re
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from nospill.core.files import atomic_text
from nospill.errors import PlanFolderError, ScenarioError
from nospill.export.base import Exporter, checked_samples, finite_row, require_joints, text_of
from nospill.export.makers import maker_of
from nospill.export.payload import payload_of
from nospill.motion.interpolation import QUINTIC_SPLINE, JointSamples
from nospill.scene.scene import Scene

RATES = (500.0, 125.0)
"""Control rates of e-Series and CB3 controllers, Hz."""
JOINTS = 6
LOOKAHEAD_TIME, LOOKAHEAD_RANGE = 0.03, (0.03, 0.2)
"""s; the shortest that the controller takes: the least lag."""
GAIN, GAIN_RANGE = 300, (100, 2000)
"""Gain of the position error; the controller's own default."""
SOCKET, NODE = FORMS = ("socket", "script-node")
"""Sent to the controller, or loaded into a node of a program."""
DECIMALS = 12
"""Of a target in rad: rounding alone shows as less than 1e-6 rad/s^2 at 500 Hz."""
START_TOLERANCE = 0.002
"""rad; farther from the first target, the program does not start."""

Lines = list[tuple[int, str]]
"""Of a program, each with its number in the file."""

_TARGET = re.compile(r"servoj\(\[([^\]]*)\], 0, 0, ([0-9.eE+-]+), ([0-9.eE+-]+), ([0-9.eE+-]+)\)")
_E_SERIES = re.compile(r"ur\d+e", re.IGNORECASE)
_JOINT_COMMENT = "# joints: "
_DEFINITION = "def nospill_motion():"


@dataclass(frozen=True, slots=True)
class Settings:
    """Form of the program, gain and look-ahead (s) of servoj."""

    form: str = SOCKET
    gain: float = GAIN
    lookahead: float = LOOKAHEAD_TIME


def comment_lines(scene: Scene, rate: float) -> list[str]:
    """Within the function: what is sent by socket begins with def."""
    return [
        f"  # written by nospill for {scene.robot.name}",
        f"  {_JOINT_COMMENT}{', '.join(scene.robot.joints)}",
        f"  # targets in rad, one every {period_text(rate)} s ({rate:g} Hz)",
        *(
            [f"  # poses of the plan are in {scene.robot.base_frame}; joints need no frame"]
            if scene.robot.base_frame
            else []
        ),
        "  # move the arm to the first target before; run with the speed slider at 100 %: scaling stretches the motion",
        "  # payload: kg, centre of mass in m, Ixx, Iyy, Izz, Ixy, Ixz, Iyz about it in kg m^2, axes of the flange",
    ]


def frame_lines(first: np.ndarray, scene: Scene, form: str) -> tuple[list[str], list[str]]:
    """The program's lines before and after the targets, but for comments."""
    before = [
        _DEFINITION,
        f"  {_payload_call(scene)}",
        f"  start = [{_row(first)}]",
        "  now = get_actual_joint_positions()",
        "  i = 0",
        f"  while i < {JOINTS}:",
        f"    if norm(now[i] - start[i]) > {START_TOLERANCE}:",
        '      popup("The arm is not at the start of the motion.", "nospill", error=True, blocking=True)',
        "      halt",
        "    end",
        "    i = i + 1",
        "  end",
    ]
    return before, ["  stopj(2.0)", "end", *(["nospill_motion()"] if form == NODE else [])]


def _payload_call(scene: Scene) -> str:
    payload = payload_of(scene)
    centre, inertia = (
        ", ".join(f"{value + 0.0:.6f}" for value in np.round(column, 6)) for column in (payload.centre, payload.six)
    )
    return f"set_target_payload({payload.mass:.4f}, [{centre}], [{inertia}])"


def _row(values: np.ndarray) -> str:
    """Fixed decimals: nowhere is it said that URScript reads exponents."""
    return ", ".join(f"{value:.{DECIMALS}f}" for value in np.round(values, DECIMALS) + 0.0)  # turns -0.0 into 0.0


def period_text(rate: float) -> str:
    """The period of a rate (Hz) as the program states it, s."""
    return f"{1.0 / rate:.6g}"


def reason_against(scene: Scene, rate: float) -> str | None:
    """Why no program moves this arm at this rate, Hz; None where one does."""
    joints = len(scene.robot.joints)
    if joints != JOINTS:
        return f"URScript moves arms of {JOINTS} joints; this one has {joints} joints"
    if maker_of(scene) != "Universal Robots":
        return (
            f"URScript is read by arms of Universal Robots; this one is {scene.robot.name} (a description of one is "
            "known by a name like ur10e, or by joints named shoulder_pan_joint and so on); choose another --format"
        )
    if rate not in RATES:
        return f"rate is {rate:g} Hz; a URScript program runs at 500 Hz (e-Series) or 125 Hz (CB3); use --rate 500"
    return None


def _caution(scene: Scene, rate: float) -> str | None:
    """The controller's generation decides its rate, and an arm's name need not tell it."""
    if _E_SERIES.fullmatch(scene.robot.name) and rate == RATES[0]:
        return None
    own, other = ("e-Series", "CB3") if rate == RATES[0] else ("CB3", "e-Series")
    needed = RATES[1] if rate == RATES[0] else RATES[0]
    return f"{rate:g} Hz is for {own} controllers; {other} ones play it at another pace and need --rate {needed:g}"


def target_lines(positions: np.ndarray, rate: float, settings: Settings) -> list[str]:
    """One call of servoj for every row (m, 6), rad."""
    arguments = f"0, 0, {period_text(rate)}, {settings.lookahead:g}, {settings.gain:g}"
    return [f"  servoj([{_row(row)}], {arguments})" for row in positions]


def _write(samples: JointSamples, scene: Scene, path: Path, settings: Settings) -> None:
    rate = round(samples.rate, 3)
    reason = reason_against(scene, rate)
    if reason is not None:
        raise ScenarioError(reason)
    before, after = frame_lines(samples.position[0], scene, settings.form)
    targets = target_lines(samples.position, rate, settings)
    lines = [before[0], *comment_lines(scene, rate), *before[1:], *targets, *after, ""]
    atomic_text(path, "\n".join(lines))


def _read(path: Path, scene: Scene) -> JointSamples:
    """The targets; besides them a program may hold nothing but what `_write` put there."""
    return program_samples(numbered_lines(path), scene, path)


def numbered_lines(path: Path) -> Lines:
    """The lines of a program without blanks at their ends, each with its number."""
    return [(number, line.strip()) for number, line in enumerate(text_of(path).splitlines(), 1)]


def targets_of(lines: Lines, path: Path) -> tuple[list[np.ndarray], list[float], list[tuple[int, str, int]]]:
    """Targets, rad, and periods, s, of some lines; and the others: number, text and how many targets are before.

    Raises:
        PlanFolderError: a target or a number that the controller does not take.
    """
    rows, periods, others = [], [], []
    for number, line in lines:
        if not line or line.startswith("#"):
            continue
        where = f"{path}, line {number}"
        match = _TARGET.fullmatch(line)
        if match is None:
            others.append((number, line, len(rows)))
            continue
        rows.append(finite_row(match[1].split(","), JOINTS, where))
        period, lookahead, gain = finite_row([match[2], match[3], match[4]], 3, where)
        for name, value, (low, high) in (
            ("lookahead_time", lookahead, LOOKAHEAD_RANGE),
            ("gain", gain, GAIN_RANGE),
        ):
            if not low <= value <= high:
                raise PlanFolderError(f"{where}: {name} is {value:g}; the controller takes {low:g} to {high:g}")
        periods.append(period)
    return rows, periods, others


def program_samples(lines: Lines, scene: Scene, path: Path) -> JointSamples:
    """The targets of a program, and of its other lines that they are those that were written.

    Raises:
        PlanFolderError: they are not, or the program is for another arm or pace.
    """
    named = [line.removeprefix(_JOINT_COMMENT).split(", ") for _, line in lines if line.startswith(_JOINT_COMMENT)]
    require_joints(named[0] if named else None, scene, path)
    rows, periods, others = targets_of(lines, path)
    if not rows:
        raise PlanFolderError(f"{path}: holds no servoj target; write it again with nospill export")
    rate = 1.0 / periods[0] if periods[0] > 0.0 else 0.0
    if len(set(periods)) > 1 or round(rate, 3) not in RATES:
        raise PlanFolderError(
            f"{path}: the period of servoj is {periods[0]:g} s or changes; 0.002 or 0.008 is expected"
        )
    _require_frame(others, np.array(rows), scene, path)
    t = np.round(np.arange(len(rows)) * periods[0] * 1e9) / 1e9
    return checked_samples(JointSamples(t, np.array(rows)), path)


def _require_frame(others: list[tuple[int, str, int]], rows: np.ndarray, scene: Scene, path: Path) -> None:
    """Refuse a program in which anything else moves the arm: its other lines are those of `_frame`, in their places."""
    before, after = frame_lines(rows[0], scene, SOCKET if others and others[-1][1] == "end" else NODE)
    wanted = [(line.strip(), 0) for line in before] + [(line.strip(), len(rows)) for line in after]
    for (number, line, place), expected in zip(others, wanted, strict=False):
        if (line, place) != expected:
            raise PlanFolderError(f"{path}, line {number}: {line[:60]!r} is not what nospill wrote there")
    if len(others) != len(wanted):
        raise PlanFolderError(f"{path}: the program has {len(others)} lines besides its targets, not {len(wanted)}")


def urscript_exporter(form: str = SOCKET, gain: float = GAIN, lookahead: float = LOOKAHEAD_TIME) -> Exporter:
    """The program in one of its forms.

    Args:
        form: "socket" or "script-node".
        gain: of the position error, 100 to 2000.
        lookahead: s, 0.03 to 0.2.

    Raises:
        ScenarioError: no such form, or a number that the controller does not take.
    """
    if form not in FORMS:
        raise ScenarioError(f"urscript: no form {form!r}; there are {', '.join(FORMS)}")
    for option, value, (low, high), unit in (
        ("gain", gain, GAIN_RANGE, ""),
        ("lookahead", lookahead, LOOKAHEAD_RANGE, " s"),
    ):
        if not low <= value <= high:
            raise ScenarioError(f"urscript: --{option} is {value:g}{unit}; servoj takes {low:g} to {high:g}{unit}")
    settings = Settings(form, gain, lookahead)
    return Exporter(
        name="urscript",
        suffixes=(".script",),
        title="URScript program of servoj targets, 500 Hz (e-Series) or 125 Hz (CB3), six joints; to be sent, or for a "
        "script node (--form)",
        receiver="Universal Robots controller: a target each control period, its drives follow (quintic spline)",
        interpolation=QUINTIC_SPLINE,
        reason_against=reason_against,
        write=lambda samples, scene, path: _write(samples, scene, path, settings),
        read=_read,
        caution=_caution,
        one_payload=True,
        options=("form", "gain", "lookahead"),
        with_options=urscript_exporter,
    )


URSCRIPT = urscript_exporter()
"""A program for Universal Robots."""
