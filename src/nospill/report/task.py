"""The task of a scenario in words, as tables."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from nospill.approach import Segment
from nospill.certification.rims import RimDistance, rim_distances
from nospill.certification.verdict import Certificate
from nospill.certification.wording import row_text, shown_unit
from nospill.core.short_names import short_names
from nospill.core.units import format_quantity, superscript
from nospill.laws.constraints import CONSTRAINTS
from nospill.laws.constraints.base import MotionKey, Role, RowId
from nospill.laws.constraints.joint_position import JointPosition
from nospill.laws.constraints.residual_height import ResidualHeight
from nospill.laws.constraints.slosh_height import SloshHeight
from nospill.laws.scene_parameters import structure_of
from nospill.motion.trajectory import Trajectory
from nospill.plots.text_pages import TextTable
from nospill.scene.cargo import Cargo
from nospill.scene.scene import Scene
from nospill.scene.tolerances import tolerance_text

_FIDELITY = {
    "deliverable": "the published equations, contact as if the liquid were frozen",
    "full": "the whole physics: moving liquid pushes its cup, contact shares its friction",
}
_END = {
    "still": "the liquids stand still at the end",
    "published": "every surface passes through its rest shape at the end; it may still be moving",
    "residual": "the liquids may still swing",
}
_SHOWN_ELSEWHERE = ("model", "urdf", "urdf_text", "limits")


def task_table(scene: Scene, *, approach: Segment | None = None) -> TextTable:
    """The task, a line each: robot, tray, path, motion rules, physics, the way to the start if there is one."""
    rows = [
        ("robot", f"{scene.robot.title} ({scene.robot.name}), {len(scene.robot.joints)} joints"),
        *_robot_lines(scene),
        ("tray", _tray(scene)),
        ("path", _path(scene)),
        ("attitude", _attitude(scene)),
        ("at the end", _end(scene)),
        *_waiting(scene, approach),
        *_tray_limits(scene),
        *_limit_lines(scene),
        ("smoothness", _jerks(scene)),
        *_tolerances(scene),
        ("physics", f"{scene.fidelity}: {_FIDELITY[scene.fidelity]}"),
        ("output", f"{scene.output_rate:g} samples per second"),
    ]
    described = str(scene.source.get("description", "") or "")
    if described:
        rows.insert(0, ("about", " ".join(described.split())))
    return TextTable("Task", (), tuple(rows))


def cargo_table(scene: Scene, certificate: Certificate) -> TextTable:
    """Every object: size, place, mass, friction, contents and how high its liquid came."""
    columns = (
        "object",
        "size",
        "at x, y",
        "mass",
        "friction",
        "contents",
        SloshHeight.name,
        "to the rim",
        ResidualHeight.name,
    )
    rims = {item.subject: item for item in rim_distances(scene, certificate.rows)}
    rows = tuple(_cargo(item, certificate, rims.get(item.name)) for item in scene.cargo)
    note = "Sizes and heights in mm, masses in kg. Friction: measured, less the reserve that the plan does not use."
    if all(item.filling is None for item in scene.cargo):
        return TextTable("On the tray", columns[:-3], tuple(row[:-3] for row in rows), note=note)
    return TextTable(
        "On the tray",
        columns,
        rows,
        note=f"{note} Heights: of the surface over its level at rest, of what is allowed; to the rim: from the edge of "
        "the plane of this height where it meets the wall, upright.",
    )


def joint_table(scene: Scene, trajectory: Trajectory, certificate: Certificate) -> TextTable:
    """Every joint: its range and the largest value of every limited quantity, against the limit."""
    rows = {row.id: row for row in certificate.rows}
    names = [item.name for item in CONSTRAINTS if item.role is Role.JOINT]
    limited = [name for name in names if name != JointPosition.name and any(key.constraint == name for key in rows)]
    columns = ["joint", "position [deg]", "allowed [deg]"]
    for name in limited:
        unit = next(row.unit for key, row in rows.items() if key.constraint == name)
        columns.append(f"{name.removeprefix('joint ')} [{superscript(shown_unit(unit)[1])}]")
    table = []
    for index, (joint, short) in enumerate(zip(scene.robot.joints, short_names(scene.robot.joints), strict=True)):
        angles = np.degrees(trajectory.joint_position[:, index])
        low, high = np.degrees((scene.robot.lower[index], scene.robot.upper[index]))
        cells = [short, _span(float(angles.min()), float(angles.max())), _span(float(low), float(high))]
        for name in limited:
            row = rows.get(RowId(name, joint))
            if row is None:
                cells.append("")
                continue
            text = row_text(row)
            cells.append(f"{text.value} of {text.limit} ({text.use})")
        table.append(tuple(cells))
    unlimited = [name for name in names if name not in limited and name != JointPosition.name]
    note = f"Not limited in this plan: {', '.join(unlimited)}." if unlimited else ""
    sources = "; ".join(f"{quantity}: {source}" for quantity, source in scene.robot.sources.items())
    return TextTable(
        "Joints and their limits", tuple(columns), tuple(table), note=f"{note} Sources: {sources}.".strip()
    )


def _robot_lines(scene: Scene) -> list[tuple[str, str]]:
    """What the scenario says about the arm beyond its name, as it was written."""
    given = scene.source.get("robot")
    entries = given if isinstance(given, Mapping) else {}
    keys = [key for key in entries if key not in _SHOWN_ELSEWHERE]
    rows = [(f"robot, {str(key).replace('_', ' ')}", _value_text(entries[key])) for key in keys]
    limits = entries.get("limits")
    if isinstance(limits, Mapping):
        rows += [(f"limit of {str(key).replace('_', ' ')}", _value_text(value)) for key, value in limits.items()]
    return rows


def _value_text(value: object) -> str:
    if isinstance(value, list | tuple):
        return ", ".join(_value_text(item) for item in value)
    if isinstance(value, Mapping):
        return ", ".join(f"{key}: {_value_text(item)}" for key, item in value.items())
    return f"{value:g}" if isinstance(value, float) else str(value)


def _tray(scene: Scene) -> str:
    tray = scene.tray
    sides = " x ".join(f"{1e3 * side:.4g}" for side in tray.size)
    offset = ", ".join(f"{1e3 * value:.4g}" for value in tray.tool.position)
    board = f", board of {tray.mass:.3g} kg" if tray.mass else ""
    turned = f", turned by {np.degrees(tray.tool.yaw):.3g} deg" if tray.tool.yaw else ""
    if not tray.tool.upright:
        angles = ", ".join(f"{np.degrees(angle):.4g}" for angle in (tray.tool.roll, tray.tool.pitch, tray.tool.yaw))
        turned = f", turned by ({angles}) deg about its x, y and z"
    return f"{sides} mm, surface at ({offset}) mm of the flange{turned}{board}"


def _path(scene: Scene) -> str:
    given = scene.source.get("path")
    entries = given if isinstance(given, Mapping) else {}
    kind = " ".join(str(entries[key]) for key in ("type", "name") if key in entries)
    start, end = scene.path.at(0.0)[0], scene.path.at(1.0)[0]
    places = [", ".join(f"{value:.3f}" for value in point[:3]).replace("-", "−") for point in (start, end)]
    corridor, rules = "", scene.motion
    if rules.corridor is not None:
        corridor = f"; the tray may leave it by up to {1e3 * rules.corridor:.4g} mm"
        if rules.corridor_shares:
            corridor += f", {1e3 * rules.corridor * min(rules.corridor_shares):.4g} mm where it is narrowest"
    if rules.via:
        names = ", ".join(f"{item.name} within {1e3 * item.radius:.4g} mm" for item in rules.via)
        corridor += f"; places it passes: {names}"
    if scene.regions:
        corridor += f"; tray and cargo stay in {', '.join(item.name for item in scene.regions)}"
    between = ", free between its ends" if rules.yaw_free else ""
    return (
        f"{kind}, {scene.path.length:.2f} m long, from ({places[0]}) m to ({places[1]}) m of the base, "
        f"yaw from {np.degrees(start[3]):.4g} to {np.degrees(end[3]):.4g} deg{between}{corridor}".replace("-", "−")
    )


def _attitude(scene: Scene) -> str:
    if scene.motion.tilt_free:
        return f"the tray may tilt, up to {np.degrees(scene.motion.max_tilt):.4g} deg about either axis"
    curve = scene.path.joint_curve
    if curve is not None:
        return f"the tray leans as the joints make it, up to {np.degrees(curve.lean.max()):.3g} deg"
    return "the tray stays level"


def _end(scene: Scene) -> str:
    if not any(item.filling for item in scene.cargo):
        return "at rest"
    rest = f"{100 * scene.motion.residual_fraction:.4g} % of the height allowed before"
    return f"{_END[scene.motion.end]}; afterwards no surface rises above {rest}"


def _waiting(scene: Scene, approach: Segment | None) -> list[tuple[str, str]]:
    rules, rows = scene.motion, []
    if rules.hold_before or rules.hold_after:
        rows.append(("holds", f"{rules.hold_before:g} s at rest before and {rules.hold_after:g} s after, in the files"))
    if approach is not None:
        tray = "loaded" if approach.loaded else "empty"
        rows.append(("approach", f"{approach.duration:.3f} s in joint space to the start, with the tray {tray}"))
    return rows


def _tolerances(scene: Scene) -> list[tuple[str, str]]:
    """What may be off, once for all objects that share it."""
    owners: dict[str, list[str]] = {}
    for item in scene.cargo:
        if item.tolerance is not None:
            owners.setdefault(tolerance_text(item.tolerance), []).append(item.name)
    whole = len(scene.cargo)
    return [
        ("tolerance" if len(names) == whole else f"tolerance of {', '.join(names)}", text)
        for text, names in owners.items()
    ]


def _jerks(scene: Scene) -> str:
    rules = scene.motion
    found = [f"third derivative of the path parameter up to {rules.path_jerk_limit:.4g} 1/s³"]
    if rules.corridor is not None:
        found.append(f"of the offset from the path up to {rules.path_jerk_limit * scene.path_length:.4g} m/s³")
    angles = [name for name, free in (("the tilt angles", rules.tilt_free), ("the yaw", rules.yaw_free)) if free]
    if angles:
        found.append(f"of {' and '.join(angles)} up to {rules.tilt_jerk_limit:.4g} rad/s³")
    return ", ".join(found)


def _tray_limits(scene: Scene) -> list[tuple[str, str]]:
    """The limits of the motion that a scenario may leave out, where it states them."""
    stated = structure_of(scene).motion_limits
    keys = ((item, item.limit_key) for item in CONSTRAINTS)
    found = [
        f"{item.name} up to {format_quantity(getattr(scene.motion, key.key), key.dimension, digits=4)}"
        for item, key in keys
        if isinstance(key, MotionKey) and key.key in stated
    ]
    return [("motion of the tray", ", ".join(found))] if found else []


def _limit_lines(scene: Scene) -> list[tuple[str, str]]:
    """Limits in addition to those of the scenario, with their numbers."""
    given = [(limit.record, "") for limit in scene.constraints] + [(one, ", not judged") for one in scene.unjudged]
    return [(f"limit: {record.name}", f"{record.text}{note}") for record, note in given]


def _cargo(item: Cargo, certificate: Certificate, rim: RimDistance | None) -> tuple[str, ...]:
    footprint = item.container.footprint
    height = f"{1e3 * item.container.height:.4g} high"
    size = " x ".join(f"{1e3 * side:.4g}" for side in footprint.sides) + f" across, {height}"
    turned = f", {np.degrees(item.yaw):.3g} deg" if item.yaw else ""
    contents = "solid" if item.contents is None else f"{len(item.contents.content)} in it, with their mass"
    if item.filling is not None:
        contents = f"{item.filling.liquid.name}, {1e3 * item.filling.liquid_height:.4g} deep"
        contents += ", lid" if item.filling.lid else ""
    return (
        item.name,
        size,
        ", ".join(f"{1e3 * value:.4g}" for value in item.position).replace("-", "−") + turned,
        f"{item.total.mass:.3f}",
        f"stands in {item.carrier}"
        if item.carrier
        else "fixed"
        if item.fixed
        else f"{item.friction:.3g} less {100 * item.friction_reserve:.3g} %",
        contents,
        _height(certificate, SloshHeight.name, item.name),
        "" if rim is None else f"{rim.left:.1f}".replace("-", "−"),
        _height(certificate, ResidualHeight.name, item.name),
    )


def _height(certificate: Certificate, constraint: str, name: str) -> str:
    for row in certificate.rows:
        if row.id == (constraint, name):
            text = row_text(row)
            linear = "" if row.linear_value is None else f" (linear {1e3 * row.linear_value:.3g})"
            return f"{text.value} of {text.limit}{linear}"
    return ""


def _span(low: float, high: float) -> str:
    return f"{low:.1f} to {high:.1f}".replace("-", "−")
