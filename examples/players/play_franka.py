"""Play a table of joints on a Franka by pylibfranka, one row each 1 ms, and log what it reports.

    nospill export out/tea --format csv --profile franka -o tea.csv
    python play_franka.py tea.csv run.csv --ip 172.16.0.2 --load 1.14 0 0.008 0.12
    nospill executed run.csv --plan out/tea

Plan with `[controller] interface = "fci"`: then every row is within what the interface checks. Run it first from a plan
that was made slower (nospill slow). The arm must stand at the first row, or --approach takes it there in a straight
line of the joints, which nothing has checked for obstacles. It needs a real-time kernel, as libfranka does.
"""

# pyright: reportMissingImports=false

from __future__ import annotations

import argparse
from pathlib import Path
from typing import Any

import numpy as np
import pylibfranka as franka
from rows import held, read_rows, require_start, way_to, write_log

RATE = 1000.0
HOLD, TAIL = 300, 800
"""Rows at rest before and after the motion."""


def play(robot: Any, rows: np.ndarray) -> tuple[list[tuple[float, np.ndarray, np.ndarray]], int]:
    """Ask for a row each cycle; the log, and how many cycles were lost."""
    control = robot.start_joint_position_control(franka.ControllerMode.JointImpedance)
    log, lost = [], 0
    for index, row in enumerate(rows):
        state, passed = control.readOnce()
        lost += max(round(1e3 * passed.to_sec()) - 1, 0) if index else 0
        log.append((index / RATE, np.array(state.q), row))
        command = franka.JointPositions(row.tolist())
        command.motion_finished = index == len(rows) - 1
        control.writeOnce(command)
    return log, lost


def run(robot: Any, rows: np.ndarray, out: Path, *, approach: bool, speed: float = 0.2) -> None:
    """Check the start or go there, hold, play, and write the log, that of a motion that was refused too."""
    q = np.array(robot.read_once().q_d)
    if not require_start(q, rows[0], may_move=approach):
        play(robot, way_to(q, rows[0], RATE, speed))
    log, lost = play(robot, held(rows, HOLD, TAIL))
    write_log(out, log, rows.shape[1])
    print(f"{out}: {len(log)} rows, {lost} cycles lost")


def main() -> None:
    """Connect and run."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("table", type=Path)
    parser.add_argument("log", type=Path)
    parser.add_argument("--ip", required=True)
    parser.add_argument("--approach", action="store_true", help="move to the first row, in a straight line")
    parser.add_argument("--load", type=float, nargs=4, metavar=("KG", "X", "Y", "Z"), help="of tray and cargo, m")
    options = parser.parse_args()
    rate, rows = read_rows(options.table)
    if rate != RATE or rows.shape[1] != 7:
        raise SystemExit(f"{options.table}: {rows.shape[1]} joints at {rate:g} Hz; export it with --profile franka")
    robot = franka.Robot(options.ip)
    if options.load:
        robot.set_load(options.load[0], options.load[1:], [0.0] * 9)
    run(robot, rows, options.log, approach=options.approach)


if __name__ == "__main__":
    main()
