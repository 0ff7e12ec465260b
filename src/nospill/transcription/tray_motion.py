"""What the objects read of the tray: the motion of its frame at four instants of an interval.

Each instant has nine numbers: angular velocity, angular acceleration, specific force; and where objects are moved at
another speed and the tray tilts, the vertical. On a level tray some of them are zero at any time; the others, stacked,
are the *motion numbers* y. They follow from the *motion variables*: the
chains of s and tilt, the length of the interval, the jerks.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache

import casadi as ca

from nospill.core.frames import SX, VERTICAL, FrameMotion, body_motion
from nospill.laws.structure import Freedom
from nospill.paths.joint_curves import POSE
from nospill.transcription.collocation import POINTS, advance_chain
from nospill.transcription.layout import IntegratorChain, Layout
from nospill.transcription.lifted_variables import LiftedVariables
from nospill.transcription.path_expression import PathPiece, piece_size
from nospill.transcription.tray_state import TrayState, tray_state

INSTANTS: tuple[float, ...] = (0.0, float(POINTS[0]), float(POINTS[1]), 0.5)
"""As fractions of the interval: the node, both collocation points, the middle."""


@dataclass(frozen=True, eq=False)
class MotionPattern:
    """Which numbers of the tray's motion there are and how they hang together.

    Attributes:
        entries: per instant, nine or twelve: the index among the motion numbers, or None where the entry is zero.
        interval: index of the length of the interval among the motion variables.
        jacobian: sparsity (motion numbers, motion variables).
        share: sparsity of the upper triangle of what an object's Hessian has of the motion numbers and, last, the
            length of the interval: no row reads two instants.
        up: the vertical of a level tray, (3, 1); None of one that tilts, whose entries have it where it is read.
    """

    entries: tuple[tuple[int | None, ...], ...]
    interval: int
    jacobian: ca.Sparsity
    share: ca.Sparsity
    up: SX | None

    @property
    def count(self) -> int:
        """Number of motion numbers."""
        return int(self.jacobian.size1())

    def frames(self, numbers: SX) -> tuple[FrameMotion, ...]:
        """The motion at every instant from the motion numbers (count, 1)."""
        return tuple(
            body_motion(ca.vertcat(*[SX(1, 1) if index is None else numbers[index] for index in instant]), up=self.up)
            for instant in self.entries
        )


@dataclass(frozen=True, slots=True)
class TrayMotions:
    """The tray over an interval.

    Attributes:
        start: at the node, every entry lifted.
        numbers: the motion numbers.
        entries: as in `MotionPattern`.
    """

    start: TrayState
    numbers: SX
    entries: tuple[tuple[int | None, ...], ...]


def advance_chains(chains: tuple[IntegratorChain, ...], jerks: SX, time: SX) -> tuple[IntegratorChain, ...]:
    """The chains after a time of constant jerks."""
    return tuple(advance_chain(chain, jerks[index], time) for index, chain in enumerate(chains))


def tray_motions(
    chains: tuple[IntegratorChain, ...],
    jerks: SX,
    interval: SX,
    pieces: tuple[PathPiece, ...],
    lifted: LiftedVariables,
    *,
    freedom: Freedom,
    gravity: SX,
    slowed: bool,
) -> TrayMotions:
    """The tray over an interval, `pieces` the path's at each of `INSTANTS`."""
    start = tray_state(pieces[0], chains, freedom=freedom, gravity=gravity).lifted(lifted)
    states = [start]
    for piece, fraction in zip(pieces[1:], INSTANTS[1:], strict=True):
        later = advance_chains(chains, jerks, fraction * interval)
        later = tuple((lifted.lift(chain[0]), lifted.lift(chain[1]), lifted.lift(chain[2])) for chain in later)
        states.append(tray_state(piece, later, freedom=freedom, gravity=gravity))
    numbers: list[SX] = []
    entries: list[tuple[int | None, ...]] = []
    for state in states:
        motion, places = state.motion, list[int | None]()
        parts = [motion.angular_velocity, motion.angular_acceleration, motion.specific_force]
        if slowed and freedom.leans:
            parts.append(state.rotation[2, :].T)
        for entry in ca.vertsplit(ca.densify(ca.vertcat(*parts))):
            places.append(None if entry.is_zero() else len(numbers))
            if not entry.is_zero():
                numbers.append(entry)
        entries.append(tuple(places))
    return TrayMotions(start, ca.vertcat(*numbers), tuple(entries))


@lru_cache(maxsize=8)
def motion_pattern(freedom: Freedom, *, slowed: bool) -> MotionPattern:
    """The pattern of a tray with some freedom; the motion variables are all variables of this layout's stage."""
    layout = Layout(freedom, redundant=0, coordinates=0, joints=0, orders=1)
    z, lifted = SX.sym("z", layout.size), LiftedVariables()
    chains = tuple(layout.chain(z, index) for index in range(layout.chains))
    columns = POSE if freedom.by_joints else 4
    pieces = tuple(PathPiece.of(SX.sym("piece", piece_size(3, columns)), columns) for _ in INSTANTS)
    found = tray_motions(
        chains,
        z[layout.jerks],
        z[layout.interval],
        pieces,
        lifted,
        freedom=freedom,
        gravity=SX.sym("g"),
        slowed=slowed,
    )
    count = found.numbers.numel()
    jacobian = lifted.jacobian_sparsity(z, found.numbers)
    rows, columns = [count] * (count + 1), list(range(count + 1))
    for instant in found.entries:
        own = [index for index in instant if index is not None]
        pairs = [(row, column) for row in own for column in own if row >= column]
        rows, columns = [*rows, *(row for row, _ in pairs)], [*columns, *(column for _, column in pairs)]
    share = ca.Sparsity.triplet(count + 1, count + 1, columns, rows)  # their transpose: the upper triangle
    up = None if freedom.leans else VERTICAL
    return MotionPattern(found.entries, layout.interval, jacobian, share, up)


def with_interval(slopes: SX, interval: int) -> SX:
    """V = d(y, h)/dz from that of y, `interval` the place of the scaled h among z."""
    last = SX(1, slopes.shape[1])
    last[0, interval] = 1
    return ca.vertcat(slopes, last)


def motion_columns(layout: Layout) -> list[int]:
    """Where the motion variables stand among the variables of a stage."""
    chains = layout.freedom.chains
    return [*range(3 * chains), layout.interval, *range(layout.jerks.start, layout.jerks.start + chains)]
