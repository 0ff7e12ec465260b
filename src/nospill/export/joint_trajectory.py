"""trajectory_msgs/JointTrajectory as a text file: YAML, as `ros2 topic pub` takes it, or JSON.

The YAML file is the bare message; joint names are in it, units in the comment above it (a message has no place for
them). It holds one key or point a line and what is behind it in JSON, which YAML includes: so it is read back with the
standard library alone. In JSON the message is under "msg", its type and units beside it.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np

from nospill.core.files import atomic_text, parsed_json
from nospill.errors import PlanFolderError, ScenarioError
from nospill.export.base import Exporter, number, numbers, text_of
from nospill.export.message import (
    MESSAGE_TYPE,
    OPTIONS,
    POINT_COLUMNS,
    RECEIVER,
    TOPIC,
    UNITS,
    Addressed,
    message_samples,
    message_table,
)
from nospill.motion.interpolation import QUINTIC_HERMITE, JointSamples
from nospill.scene.scene import Scene

YAML_SUFFIXES, JSON_SUFFIXES = (".yaml", ".yml"), (".json",)


def _point(point: dict[str, Any]) -> str:
    """One point as JSON whose numbers are numbers to YAML 1.1 too."""
    columns = [f'"{name}": [{numbers(np.array(point[name]))}]' for name in POINT_COLUMNS]
    stamp = point["time_from_start"]
    return "{" + ", ".join(columns) + f', "time_from_start": {json.dumps(stamp)}' + "}"


def about_lines(kind: str, samples: JointSamples, scene: Scene) -> list[str]:
    """The comments above a message of this kind."""
    units = ", ".join(f"{name} in {unit}" for name, unit in UNITS.items())
    return [
        f"# {kind}, written by nospill for {scene.robot.name}",
        f"# {units}; {number(round(samples.rate, 3))} samples per second",
    ]


def message_lines(samples: JointSamples, scene: Scene, sent: Addressed) -> list[str]:
    """The message as lines of YAML."""
    table = message_table(samples, scene, sent)
    return [
        f"header: {json.dumps(table['header'])}",
        f"joint_names: {json.dumps(table['joint_names'])}",
        "points:",
        *(f"- {_point(point)}" for point in table["points"]),
    ]


def yaml_text(samples: JointSamples, scene: Scene, sent: Addressed) -> str:
    """The message as YAML, with the command that sends it."""
    sending = f"# ros2 topic pub --once --stdin {sent.topic or TOPIC} {MESSAGE_TYPE} < this file"
    lines = [*about_lines(MESSAGE_TYPE, samples, scene), sending, *message_lines(samples, scene, sent), ""]
    return "\n".join(lines)


def json_text(samples: JointSamples, scene: Scene, sent: Addressed) -> str:
    """The message as JSON, under "msg"."""
    table = message_table(samples, scene, sent)
    points = ",\n".join(_point(point) for point in table["points"])
    return (
        f'{{"type": {json.dumps(MESSAGE_TYPE)},\n"robot": {json.dumps(scene.robot.name)},\n'
        f'"units": {json.dumps(UNITS)},\n"msg": {{"header": {json.dumps(table["header"])},\n'
        f'"joint_names": {json.dumps(table["joint_names"])},\n"points": [\n{points}\n]}}}}\n'
    )


def yaml_table(text: str, path: Path) -> dict[str, Any]:
    """The keys of a message that was written line by line.

    Raises:
        PlanFolderError: a line that is none of those.
    """
    table: dict[str, Any] = {}
    for count, line in enumerate(text.splitlines(), 1):
        content = line.strip()
        if not content or content.startswith("#"):
            continue
        try:
            if content.startswith("- "):
                table["points"].append(parsed_json(content[2:]))
            else:
                key, _, value = content.partition(":")
                table[key] = parsed_json(value) if value.strip() else []
        except (ValueError, KeyError, AttributeError):
            raise PlanFolderError(
                f"{path}, line {count}: {content[:60]!r} is not a line of a trajectory that nospill wrote"
            ) from None
    return table


def _json_table(text: str, path: Path) -> Any:
    try:
        table = parsed_json(text)
    except ValueError as error:
        raise PlanFolderError(f"{path}: not a JSON file ({error})") from error
    return table.get("msg") if isinstance(table, dict) else None


def _is_json(path: Path) -> bool:
    if not path.name.endswith(YAML_SUFFIXES + JSON_SUFFIXES):
        raise ScenarioError(f"{path}: a joint trajectory is written as .yaml, .yml or .json; name the file so")
    return path.name.endswith(JSON_SUFFIXES)


def joint_trajectory_exporter(prefix: str = "", topic: str = "", lead: float = 0.0, begins: float = 0.0) -> Exporter:
    """The message as it is sent.

    Raises:
        ScenarioError: see `message.Addressed`.
    """
    sent = Addressed(prefix, lead, topic, begins)

    def write(samples: JointSamples, scene: Scene, path: Path) -> None:
        text = json_text if _is_json(path) else yaml_text
        atomic_text(path, text(samples, scene, sent))

    def read(path: Path, scene: Scene) -> JointSamples:
        table = _json_table if _is_json(path) else yaml_table
        return message_samples(table(text_of(path), path), scene, path, sent)

    return Exporter(
        name="joint-trajectory",
        suffixes=YAML_SUFFIXES + JSON_SUFFIXES,
        title="trajectory_msgs/JointTrajectory as YAML or JSON: positions, velocities, accelerations",
        receiver=RECEIVER,
        interpolation=QUINTIC_HERMITE,
        reason_against=lambda scene, rate: None,
        write=write,
        read=read,
        uneven=True,
        options=OPTIONS,
        with_options=joint_trajectory_exporter,
        beginning=lambda begins: joint_trajectory_exporter(prefix, topic, lead, begins),
    )


JOINT_TRAJECTORY = joint_trajectory_exporter()
"""The message of ROS in a text file."""
