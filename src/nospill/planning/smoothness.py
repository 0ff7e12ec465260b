"""How much smoother a motion has to be: the factor on the weights of the jerks, by one law for every reason.

Some rows neither back-off nor margins bring back. Waves of modes outside the problem, of higher orders, of late joints
and of joints that ring add up over the whole motion, and quick changes of the jerks are what drives them. Each cause
has one use, the largest of the rows that smoothness alone lowers, and one line in the table below: such a use falls
about as a power of the weights, so they rise as a power of it, within what a round may change.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

_HEAVIEST = 1e4
"""Factor on the weights in all."""
_LEAST_USE, _LEAST_FALL, _MOST_FALL = 5e-4, 0.08, 0.8
"""Use that counts at least; power with which uses fall as the weights rise, least and most that two motions show."""
_OF_SMOOTH = 0.42
"""Power of the factor of a smooth motion with which a motion begins whose waves of second order become states."""
_ELSEWHERE = 0.42
"""The same of the motion before, with which one to another goal begins."""


@dataclass(frozen=True, slots=True)
class Cause:
    """Why jerks weigh more, and by how much.

    Attributes:
        power: of use over aim, by which the weights rise; where motions show how a use falls, before two of them did.
        least, most: factor on the weights in one round.
        heaviest: in all.
        acts_from: use from which they rise.
        aim: use that they are to lead to.
        fall: power of use over aim by which they fall after a motion that holds.
        least_fall, most_fall: factor by which they fall in one round, above 1.
        by_secants: whether two motions say how the use falls, for the third.
        halves: whether they rise half way, in powers, to those of a motion that held, and no further.
    """

    power: float
    least: float
    most: float
    heaviest: float = _HEAVIEST
    acts_from: float = 1.0
    aim: float = 1.0
    fall: float = 0.0
    least_fall: float = 1.0
    most_fall: float = 1.0
    by_secants: bool = False
    halves: bool = False


OTHER_MODES = Cause(power=2.0, least=2.0, most=_HEAVIEST)
"""Modes outside the problem that are over by themselves after the end."""
SECOND_ORDER = Cause(power=2.0, least=1.4, most=300.0, fall=0.5, most_fall=2.5)
"""What the second order adds after the end, over what the limit leaves it. Four cups on a tilting tray, 10 mm: 4.7, 3,
1.7, 1.3, 0.1 mm with 1, 10, 100, 300, 1000 times the weights."""
FLOW = Cause(power=2.0, least=1.25, most=5.0, fall=2.0, most_fall=5.0)
"""What the nonlinear flow leaves beside the waves that are states of the problem."""
LATE_AT_ONCE = Cause(power=4.0, least=30.0, most=60.0, heaviest=60.0, acts_from=1.5, aim=0.985, by_secants=True)
"""What late joints leave after the end, before any margins: those of a rough motion are too much."""
LATE = Cause(power=2.5, least=1.05, most=2.0, aim=0.985, fall=2.5, most_fall=1.5, by_secants=True)
"""The same once rows have margins."""
STILLED = Cause(power=1.0, least=1.05, most=1.5, aim=0.985, fall=1.0, most_fall=1.5)
"""The same where late joints are stilled: the rest changes from round to round with the motion that gains are of."""
RINGING = Cause(power=2.0, least=1.25, most=10.0, least_fall=3.0, most_fall=3.0, halves=True)
"""Any row where joints ring: steps of the jerk let them. After a motion that holds nothing says which row lighter jerks
would be too much for."""


@dataclass(frozen=True, slots=True)
class Tried:
    """What a factor on the weights led to.

    Attributes:
        factor: above 0.
        use: the largest of the rows that it lowers.
    """

    factor: float
    use: float


@dataclass(frozen=True, slots=True)
class Smoothness:
    """The factor on the weights of the jerks, and what is known of others.

    Attributes:
        factor: at least 1.
        tried: what another one led to, where secants are asked for.
        held_with: one with which a motion held, where what held is gone back to.
        stilled: whether what late joints leave after the end is a part of the cost (`transcription.late_sums`).
    """

    factor: float = 1.0
    tried: Tried | None = None
    held_with: float = math.inf
    stilled: bool = False

    def heavier(self, cause: Cause, use: float) -> Smoothness:
        """For the next problem: jerks of more weight where a use is too much, else the same.

        Args:
            cause: why.
            use: of the answer to the last one.
        """
        if use < cause.acts_from or self.factor >= cause.heaviest:
            return self
        ratio = (use / cause.aim) ** self._power(cause, use, cause.power)
        factor = min(self.factor * min(max(ratio, cause.least), cause.most), cause.heaviest)
        if cause.halves and self.factor < self.held_with:
            factor = min(factor, math.sqrt(self.factor * self.held_with))
        return replace(self, factor=factor, tried=Tried(self.factor, use) if cause.by_secants else self.tried)

    def lighter(self, cause: Cause, use: float) -> Smoothness:
        """After a motion that holds: jerks of less weight, as far as its use leaves room; arguments as of `heavier`."""
        use = max(use, _LEAST_USE)
        ratio = (use / cause.aim) ** self._power(cause, use, cause.fall)
        factor = max(self.factor * min(max(ratio, 1.0 / cause.most_fall), 1.0 / cause.least_fall), 1.0)
        tried = Tried(self.factor, use) if cause.by_secants else self.tried
        return replace(self, factor=factor, tried=tried, held_with=self.factor if cause.halves else self.held_with)

    @property
    def with_late_stilled(self) -> Smoothness:
        """Where late joints are stilled instead: jerks weigh as little as they do at once for them, at most."""
        return Smoothness(min(self.factor, LATE_AT_ONCE.least), stilled=True)

    @property
    def with_waves_as_states(self) -> Smoothness:
        """After a smooth motion, for a first problem that stills some of the waves by their phase."""
        return Smoothness(max(self.factor**_OF_SMOOTH, 1.0))

    @property
    def elsewhere(self) -> Smoothness:
        """For a motion along a way that was moved: what one goal asked for says little of another.

        Weights rise where the flow leaves too much, and those of a loop would add up.
        """
        return Smoothness(max(self.factor**_ELSEWHERE, 1.0))

    @property
    def may_rise(self) -> bool:
        """Whether jerks may weigh more, for one reason or another."""
        return self.factor < _HEAVIEST

    def _power(self, cause: Cause, use: float, unknown: float) -> float:
        if not cause.by_secants or self.tried is None or self.factor == self.tried.factor:
            return unknown
        seen = math.log(self.tried.use / max(use, _LEAST_USE)) / math.log(self.factor / self.tried.factor)
        return 1.0 / min(max(seen, _LEAST_FALL), _MOST_FALL)


AS_STATED = Smoothness()
"""Jerks that weigh as the scenario or the duration has it."""
