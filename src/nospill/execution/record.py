"""What was executed as a table for programs, and in sentences for people."""

from __future__ import annotations

from typing import Any

import numpy as np

from nospill.certification.happening import is_on_tray, tray_first
from nospill.certification.verdict import Row, limit_use
from nospill.execution.bands import NOT_CERTIFIED, OPEN
from nospill.execution.executed import Executed
from nospill.execution.tracking import Tracking
from nospill.plans.swings import swing_table

_SMALL = 0.01
"""mm; narrower bands are not told apart."""
_EXACT = 1e-9
"""rad and m; what rounding makes of a log that holds the command itself."""


def band_text(found: Executed, row: Row) -> str:
    """Half width of the band of a row's use, "± 0.3 %"; "-" where there is none or nothing is known of it."""
    band = use_band(found, row)
    return f"± {100 * band:.2g} %" if band else "-"


def use_band(found: Executed, row: Row) -> float | None:
    """Half width of the 95 % band of a row's use of its limit; None where nothing is known of it."""
    band = found.bands.get(row.id)
    if band is None or not np.isfinite(band):
        return None
    return float(limit_use(row.known, row.limit, row.worst_margin - band)) - row.use


def undecided(found: Executed) -> list[Row]:
    """Rows that cannot be told: their limit is within what noise and smoothing leave open."""
    return [row for row in found.judgement.certificate.rows if found.outcomes[row.id] == OPEN]


def open_line(found: Executed) -> str:
    """The rows that cannot be told, in one line; empty where all can."""
    names = ", ".join(f"{row.constraint} of {row.subject}" for row in undecided(found))
    what = "rate" if found.recorded.is_exact else "noise"
    return f"the {what} of the log leaves open: {names}" if names else ""


def failing(found: Executed) -> list[Row]:
    """Rows that fail beyond what noise and smoothing leave open, those about the tray first, each by its use."""
    rows = [row for row in found.judgement.certificate.rows if found.outcomes[row.id] == NOT_CERTIFIED]
    return tray_first(sorted(rows, key=lambda row: -row.use))


def mark(found: Executed, row: Row) -> str:
    """What a table says beside a row that does not hold: "FAILS" or "open"."""
    return {NOT_CERTIFIED: "FAILS", OPEN: "open"}.get(found.outcomes[row.id], "")


def verdict(found: Executed) -> str:
    """The verdict with how many rows fail and how many cannot be told, on one line."""
    rows, states = found.judgement.certificate.rows, list(found.outcomes.values())
    failed, left = states.count(NOT_CERTIFIED), states.count(OPEN)
    counted = f"all {len(rows)} rows hold"
    if failed or left:
        own = sum(not is_on_tray(row) for row in failing(found))
        arm = f" ({own} of the arm or its motion)" if own else ""
        parts = [f"{failed} fail{arm}" if failed else "", f"{left} cannot be told" if left else ""]
        counted = f"of {len(rows)} rows {' and '.join(part for part in parts if part)}"
    return f"{found.word}: {counted} on a grid of {found.judgement.certificate.grid_hz:g} Hz"


def height_text(height: float, band: float) -> str:
    """A height and the half width of its band, m, in mm: "15.01 ± 0.02"."""
    if band == 0.0:
        return f"{1e3 * height:.2f}"
    wide = f"± {1e3 * band:.2f}" if 1e3 * band >= _SMALL else f"± < {_SMALL:g}"
    return f"{1e3 * height:.2f} {wide}"


def log_lines(found: Executed) -> list[str]:
    """The log, its clock and its noise, a sentence each."""
    recorded, sampling = found.recorded, found.recorded.sampling
    log, rows = recorded.log, len(recorded.log.t)
    moves = f"the arm moves from {recorded.begin:.3f} s to {recorded.end:.3f} s"
    read = [f"read: {log.read}"] if log.read else []
    lines = [
        *read,
        f"log: {log.origin}, {rows} rows, {1.0 / sampling.period:.2f} Hz, {log.t[-1] - log.t[0]:.3f} s; {moves}",
    ]
    if sampling.jitter > 1e-7:
        taken = (
            "which the positions do not follow: the samples are even"
            if sampling.even
            else "which the positions follow: the samples were taken at the stamps"
        )
        clock = (
            f"stamps are off by {1e3 * sampling.jitter:.3f} ms (rms; at most {1e3 * sampling.largest_jitter:.2f} ms)"
        )
        clock += f", {taken}"
    else:
        clock = "stamps are even"
    clock += f"; {sampling.missing} samples missing, {sampling.doubled} doubled and left out"
    lines.append(f"clock: {clock}")
    noise = ", ".join(f"{value:.1e}" for value in recorded.smooth.noise)
    grid = float(np.max(sampling.resolution))
    if recorded.is_exact:
        lines.append("noise: none, as of a file of commands; the samples are taken as they are")
    else:
        lines.append(f"noise: {noise} rad by joint" + (f"; resolution {grid:.1e} rad" if grid > 0.0 else ""))
    return lines


def tracking_lines(found: Executed) -> list[str]:
    """How the arm followed what it was asked for, a sentence each; none where that is not known."""
    own = found.tracking
    if own is None:
        return []
    joints = found.scene.robot.joints
    told = [(name, value) for name, value in zip(joints, own.delay, strict=True) if np.isfinite(value)]
    against = "behind the command in the log" if own.of_command else "against the plan's clock, on the mean"
    delays = ", ".join(f"{name} {1e3 * value:+.2f} ms" for name, value in told) or "no joint moves enough"
    worst = int(np.argmax(own.error))
    lines = [f"delay {against}: {delays}"]
    if found.planned is not None:
        lines.insert(
            0, f"clock: the plan begins at {found.clock:.4f} s of the log, delays that all joints share included"
        )
    if max(own.error[worst], own.tray_error) < _EXACT:
        return [*lines, f"tracking: exact, within {1e3 * _EXACT:.0e} mrad and mm"]
    place = f"{joints[worst]} at {own.error_at[worst]:.3f} s"
    tray = f"the tray {1e3 * own.tray_error:.3g} mm at {own.tray_error_at:.3f} s"
    lines.append(f"tracking: at most {1e3 * own.error[worst]:.3g} mrad ({place}), {tray}")
    return lines


def executed_table(found: Executed) -> dict[str, Any]:
    """Everything as plain values in SI units; the keys are stable."""
    recorded, sampling = found.recorded, found.recorded.sampling
    rows = []
    for row, plain in zip(found.judgement.certificate.rows, found.judgement.certificate.to_dict()["rows"], strict=True):
        widths = {"band": found.bands.get(row.id), "smoothing": found.smoothing.get(row.id)}
        finite = {name: value if value is None or np.isfinite(value) else None for name, value in widths.items()}
        bare = found.without_reserve.get(row.id)
        rows.append(plain | finite | {"use_without_reserve": bare, "outcome": found.outcomes[row.id]})
    joints = found.scene.robot.joints
    return {
        "scenario": found.scene.name,
        "log": recorded.log.origin,
        "read": recorded.log.read,
        "ok": found.ok,
        "outcome": found.outcome,
        "begin_s": recorded.begin,
        "end_s": recorded.end,
        "clock_s": found.clock,
        "sampling": {
            "period_s": sampling.period,
            "jitter_s": sampling.jitter,
            "largest_jitter_s": sampling.largest_jitter,
            "even": sampling.even,
            "missing": sampling.missing,
            "doubled": sampling.doubled,
        },
        "noise_rad": dict(zip(joints, map(float, recorded.smooth.noise), strict=True)),
        "resolution_rad": dict(zip(joints, map(float, sampling.resolution), strict=True)),
        "executed": {
            "ok": found.judgement.certificate.ok,
            "grid_hz": found.judgement.certificate.grid_hz,
            "rows": rows,
        },
        "planned": None if found.planned is None else found.planned.certificate.to_dict(),
        "tracking": None if found.tracking is None else _tracking_table(found.tracking, joints),
        "left_at_end": {
            name: swing_table(item.swing)
            | {"t_s": item.t, "height_deviation_m": item.height_spread.tolist(), "covariance": item.covariance.tolist()}
            for name, item in found.left.items()
        },
        "peak_height_m": {name: float(np.max(values)) for name, values in found.heights.items()},
        "peaks": [
            {
                "constraint": peak.constraint,
                "subject": peak.subject,
                "planned": peak.planned,
                "executed": peak.executed,
                "by_joint": dict(peak.by_joint),
            }
            for peak in found.peaks
        ],
        "measured": {
            name: {
                "predicted_peak_m": own.predicted_peak,
                "measured_peak_m": own.measured_peak,
                "rmse_m": own.rmse,
                "correlation": own.correlation,
                "clock_shift_s": own.shift,
            }
            for name, own in found.measured.items()
        },
    }


def _tracking_table(own: Tracking, joints: tuple[str, ...]) -> dict[str, Any]:
    delays = [float(value) if np.isfinite(value) else None for value in own.delay]
    return {
        "delay_s": dict(zip(joints, delays, strict=True)),
        "delay_is_behind_command": own.of_command,
        "error_rad": dict(zip(joints, map(float, own.error), strict=True)),
        "tray_error_m": own.tray_error,
        "tray_error_at_s": own.tray_error_at,
    }
