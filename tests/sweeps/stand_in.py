"""Programs in the place of the planning process: they answer at once, or misbehave as a point tells them to."""

from __future__ import annotations

from pathlib import Path

from nospill.sweeps.processes import WorkerPool

PROGRAM = """
import json, os, sys, time
for text in sys.stdin:
    request = json.loads(text)
    if "scenario" in request:
        continue
    friction = request["values"]["tray.friction"]
    if friction == 0.31:
        os.kill(os.getpid(), 9)
    if friction == 0.32:
        time.sleep(600)
    if friction == 0.33:
        kept = bytearray(400_000_000)
        kept[::4096] = bytes(len(kept[::4096]))
        time.sleep(600)
    if friction == 0.34:
        raise ValueError("no such thing")
    line = {"ending": "planned", "figures": {"duration_s": 2.0 - friction, "largest_use": 0.9}, "nearest": "slip of c1"}
    if friction == 0.35:
        line = {"ending": "no motion", "reason": "No motion found: slip of c1"}
    warm = request["warm"]
    print(json.dumps(line | {"warm_from": warm["key"] if warm else "", "nospill": str(os.getpid())}), flush=True)
"""


def stand_ins(folder: Path) -> WorkerPool:
    """A pool of them."""
    (folder / "stand_in_process.py").write_text(PROGRAM)
    return WorkerPool("stand_in_process", {"PYTHONPATH": str(folder)})
