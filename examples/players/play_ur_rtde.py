"""Play a table of joints on a Universal Robots arm by ur_rtde, one servoJ a row, and record what RTDE reports.

    nospill export out/tea --format csv --profile servoj -o tea.csv
    python play_ur_rtde.py tea.csv run.csv --ip 192.168.1.2 --load 1.14 0 0.008 0.12
    nospill executed run.csv --plan out/tea

Run it first from a plan that was made slower (nospill slow); the speed slider must stand at 100 %, or the motion is
another one. The arm must stand at the first row, or --approach takes it there by moveJ, which nothing has checked for
obstacles. The joints follow about the look-ahead time late, all of them alike.
"""

# pyright: reportMissingImports=false

from __future__ import annotations

import argparse
import time
from pathlib import Path
from typing import Any

import numpy as np
from rows import held, read_rows, require_start

REST = 0.5
"""s at rest before and after the motion, of the record."""
RECORDED = ["timestamp", "actual_q", "target_q"]


def run(
    control: Any,
    receive: Any,
    rows: np.ndarray,
    rate: float,
    out: Path,
    *,
    approach: bool,
    lookahead: float = 0.03,
    gain: float = 2000.0,
    rest: float = REST,
) -> None:
    """Check the start or go there, record, hold, play, hold."""
    if not require_start(np.array(receive.getActualQ()), rows[0], may_move=approach):
        control.moveJ(rows[0].tolist(), 0.2, 0.5)
    still = round(rest * rate)
    receive.startFileRecording(str(out), RECORDED)
    try:
        for row in held(rows, still, still):
            begun = control.initPeriod()
            control.servoJ(row.tolist(), 0.0, 0.0, 1.0 / rate, lookahead, gain)
            control.waitPeriod(begun)
    finally:
        control.servoStop()
        time.sleep(rest)
        receive.stopFileRecording()
    print(f"{out}: {len(rows)} rows played at {rate:g} Hz")


def main() -> None:
    """Connect and run."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("table", type=Path)
    parser.add_argument("log", type=Path)
    parser.add_argument("--ip", required=True)
    parser.add_argument("--approach", action="store_true", help="moveJ to the first row")
    parser.add_argument("--load", type=float, nargs=4, metavar=("KG", "X", "Y", "Z"), help="of tray and cargo, m")
    parser.add_argument("--lookahead", type=float, default=0.03, help="s, of servoJ: 0.03 to 0.2")
    parser.add_argument("--gain", type=float, default=2000.0, help="of servoJ: 100 to 2000")
    options = parser.parse_args()
    rate, rows = read_rows(options.table)
    if rows.shape[1] != 6:
        raise SystemExit(f"{options.table}: {rows.shape[1]} joints; export it with --profile servoj")
    import rtde_control
    import rtde_receive

    control = rtde_control.RTDEControlInterface(options.ip, rate)
    receive = rtde_receive.RTDEReceiveInterface(options.ip, rate)
    if options.load:
        control.setPayload(options.load[0], options.load[1:])
    chosen = {"lookahead": options.lookahead, "gain": options.gain}
    run(control, receive, rows, rate, options.log, approach=options.approach, **chosen)


if __name__ == "__main__":
    main()
