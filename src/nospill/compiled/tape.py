"""The instructions of a function as plain data, of which C source is written and which is interpreted."""

from __future__ import annotations

from array import array
from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class Tape:
    """A function of dense columns, one instruction after the other.

    Attributes:
        name: of the function.
        rows_in: of each input.
        rows_out: of each output.
        shared: places of the inputs that are the same for all columns.
        registers: number of places for values, which are used again.
        code: four integers an instruction: its code (see `operations`), the register of its result, and the registers
            of its operands. An input has its place and row as operands, a constant its number; an output has its place
            as result, the register and the row as operands.
        constants: by their numbers.
        steps: how often it runs, one time after the other: its first input is its first output of the time before, and
            what is shared has a column for each time.
    """

    name: str
    rows_in: tuple[int, ...]
    rows_out: tuple[int, ...]
    shared: frozenset[int]
    registers: int
    code: array[int]
    constants: array[float]
    steps: int = 1

    @property
    def count(self) -> int:
        """Number of instructions."""
        return len(self.code) // 4
