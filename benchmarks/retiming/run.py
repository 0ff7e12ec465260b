"""The joint paths of `draw`, judged as toppra times them and timed anew, with an empty tray and with a cup.

    python -m benchmarks.retiming.run [--out FILE]     needs `pip install toppra`; without it its columns are empty

toppra gets the curve that is planned along, and the same limits of speed and acceleration. Times are of the processor.
"""

from __future__ import annotations

import argparse
import json
import time
from pathlib import Path
from statistics import median
from typing import Any

import numpy as np

import nospill as ns
from benchmarks.retiming.draw import ARMS, PATHS, task
from nospill.verify import verify

# pyright: reportMissingImports=false, reportAttributeAccessIssue=false


def by_toppra(scene: ns.Scene) -> dict[str, np.ndarray] | None:
    """Times and joints at 125 Hz as toppra has them; None where it is not installed."""
    try:
        import toppra
        from toppra import algorithm, constraint
    except ImportError:
        return None
    toppra.setup_logging("ERROR")
    curve, robot = scene.path.joint_curve, scene.robot
    assert curve is not None and robot.max_acceleration is not None
    s = np.linspace(0.0, 1.0, 801)
    path = toppra.SplineInterpolator(s, curve.joints(s))
    limits = [
        constraint.JointVelocityConstraint(np.column_stack([-robot.max_speed, robot.max_speed])),
        constraint.JointAccelerationConstraint(np.column_stack([-robot.max_acceleration, robot.max_acceleration])),
    ]
    timed = algorithm.TOPPRA(limits, path, gridpoints=np.linspace(0.0, 1.0, 1501)).compute_trajectory(0.0, 0.0)
    t = np.linspace(0.0, timed.duration, max(round(125 * timed.duration), 12))
    speed = timed(t, 1)
    speed[[0, -1]] = 0.0
    return {"t": t, "q": timed(t), "qd": speed}


def line_of(number: int, model: str, points: list[list[float]], *, cup: bool) -> dict[str, Any]:
    """What becomes of one path."""
    arm = next(item for item in ARMS if item.model == model)
    scene = task(arm, points, cup=cup)
    line: dict[str, Any] = {"number": number, "arm": model, "cup": cup, "points": len(points)}
    other = by_toppra(scene)
    if other is not None:
        line["toppra_s"] = float(other["t"][-1])
        judged = ns.judge(other, scene)
        line["toppra_certified"], line["toppra_fails"] = judged.certificate.ok, [f["code"] for f in judged.failures()]
    start = time.process_time()
    try:
        plan = ns.plan(scene)
    except ns.NospillError as error:
        return line | {"reason": str(error)}
    line |= {"processor_s": round(time.process_time() - start, 3), "duration_s": plan.duration}
    line["certified"] = plan.certificate.ok
    if plan.certificate.ok:
        line["at_8_khz"] = ns.certify(plan.trajectory, scene, rate=8000.0).ok
        line["stays"] = verify(plan).ok
    return line


def main() -> None:
    """Run and report."""
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--out", type=Path, help="one JSON line a path")
    options = parser.parse_args()
    lines = []
    for cup in (False, True):
        for item in json.loads(PATHS.read_text(encoding="utf-8")):
            lines.append(line_of(item["number"], item["arm"], item["points"], cup=cup))
            print(json.dumps(lines[-1]), flush=True)
    if options.out is not None:
        options.out.write_text("".join(json.dumps(line) + "\n" for line in lines), encoding="utf-8")
    for cup in (False, True):
        own = [line for line in lines if line["cup"] == cup]
        good = [line for line in own if line.get("certified")]
        ratios = [line["duration_s"] / line["toppra_s"] - 1.0 for line in good if "toppra_s" in line]
        print(
            f"{'cup' if cup else 'empty tray'}: {len(good)} of {len(own)} certified, "
            f"{sum(not line['at_8_khz'] for line in good)} refused at 8 kHz, "
            f"{sum(not line['stays'] for line in good)} moved in MuJoCo, "
            f"{median(line['processor_s'] for line in good):.2f} s of processor time in the median"
            + (f", {100 * median(ratios):.1f} % (at most {100 * max(ratios):.1f}) over toppra" if ratios else "")
        )


if __name__ == "__main__":
    main()
