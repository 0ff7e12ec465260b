"""Pages that are tables of the package: constraints, exporters, robots, shapes, liquids, the command line."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from typing import Any

import typer

from nospill.cli import app
from nospill.export import EXPORTERS
from nospill.laws.constraints import BY_NAME
from nospill.motion_files.receivers import RECEIVERS
from nospill.robots.description.catalog import robot_table
from nospill.robots.interfaces import INTERFACES
from nospill.scenario.examples import EXAMPLES
from nospill.scene.containers import CONTAINERS
from nospill.scene.liquids import LIQUIDS


def markdown_table(columns: Sequence[str], rows: Iterable[Sequence[object]]) -> str:
    """A Markdown table; bars and line ends inside cells are taken care of."""
    lines = [list(columns), ["---"] * len(columns), *([_cell(value) for value in row] for row in rows)]
    return "".join(f"| {' | '.join(line)} |\n" for line in lines)


def _cell(value: object) -> str:
    return " ".join(str(value).split()).replace("|", r"\|")


def _sentence(text: str) -> str:
    """The first paragraph of a docstring as one line."""
    return " ".join(text.split("\n\n")[0].split())


def constraints_table() -> str:
    """Name, unit, place and meaning of every constraint, in the order of the certificate."""
    where = {"object": "all along", "joint": "all along", "control": "all along", "end": "at the end"}
    rows = [
        (
            f"**{item.name}**",
            {"1": "fraction"}.get(item.unit, item.unit),
            where.get(item.evaluated_at.value, item.evaluated_at.value),
            item.description,
            f"`{type(item).__module__.removeprefix('nospill.').replace('.', '/')}.py`",
        )
        for item in BY_NAME.values()
    ]
    return markdown_table(("constraint", "unit", "judged", "what it says", "file"), rows)


def receivers_table() -> str:
    """Name of every receiver of a motion file, and how it moves between the points."""
    return markdown_table(("name", "who plays it"), [(f"`{item.name}`", item.title) for item in RECEIVERS.values()])


def interfaces_table() -> str:
    """Name of every interface of a controller, what it is, how often it reads a command, and which arms have it."""
    arms = robot_table()
    rows = [
        (
            f"`{item.name}`",
            item.title,
            f"{item.rates[1]:g} to {item.rates[2]:g} ({item.rates[0]:g})"
            if item.any_rate
            else " or ".join(f"{rate:.5g}" for rate in item.rates),
            ", ".join(f"`{arm['name']}`" for arm in arms if item.name in arm["interfaces"]),
        )
        for item in INTERFACES.values()
    ]
    return markdown_table(("`interface`", "what it is", "positions a second", "arms of the catalogue"), rows)


def exporters_table() -> str:
    """Name, file names, format and receiver of every exporter."""
    rows = [
        (
            f"`{item.name}`",
            ", ".join(f"`{suffix}`" for suffix in item.suffixes),
            f"`{item.plan_file}`" if item.plan_file else "-",
            item.title,
            item.receiver,
        )
        for item in EXPORTERS.values()
    ]
    return markdown_table(("exporter", "file names", "in every plan folder", "format", "played by"), rows)


def shapes_table() -> str:
    """Name of every container shape and what its class says of itself."""
    return markdown_table(
        ("`shape`", "what it is"), [(f'`"{k}"`', _sentence(v.__doc__ or "")) for k, v in CONTAINERS.items()]
    )


def liquids_table() -> str:
    """Properties of every liquid a scenario can name."""
    rows = [
        (f'`"{n}"`', f"{x.density:g}", f"{1e6 * x.kinematic_viscosity:g}", f"{1e3 * x.surface_tension:g}", x.source)
        for n, x in LIQUIDS.items()
    ]
    columns = ("`liquid`", "density, kg/m^3", "kinematic viscosity, mm^2/s", "surface tension, mN/m", "source")
    return markdown_table(columns, rows)


def robots_page() -> str:
    """The table of the catalogue, then limits and sources of each arm."""
    arms = robot_table()
    overview = [
        (f"`{arm['name']}`", arm["title"], len(_list(arm["joints"])), _known(arm["reach_m"]), _known(arm["payload_kg"]))
        for arm in arms
    ]
    text = markdown_table(("`model`", "arm", "joints", "reach, m", "payload, kg"), overview)
    return text + "".join(_arm(arm) for arm in arms)


_JOINT_COLUMNS = {
    "lower_deg": "least, deg",
    "upper_deg": "greatest, deg",
    "max_speed_deg_s": "speed, deg/s",
    "braking_deceleration_rad_s2": "braking, rad/s^2",
    "braking_offset_rad_s": "offset, rad/s",
    "max_acceleration_rad_s2": "acceleration, rad/s^2",
    "max_jerk_rad_s3": "jerk, rad/s^3",
    "max_torque_nm": "torque, N m",
    "home_deg": "home, deg",
}
"""Keys of a robot's row that hold one figure a joint, and how the page calls them."""


def _arm(arm: dict[str, Any]) -> str:
    joints = _list(arm["joints"])
    columns = [key for key in _JOINT_COLUMNS if isinstance(arm.get(key), list) and len(arm[key]) == len(joints)]
    rows = [
        (f"`{joint}`", *(f"{arm[key][index]:g}" if arm[key][index] is not None else "-" for key in columns))
        for index, joint in enumerate(joints)
    ]
    sources = "".join(f"- {quantity}: {source}\n" for quantity, source in dict(arm["sources"]).items())
    unknown = ", ".join(str(item) for item in _list(arm["not_known"]))
    missing = f"\nNot stated in these sources: {unknown}.\n" if unknown else ""
    table = markdown_table(("joint", *(_JOINT_COLUMNS[key] for key in columns)), rows)
    frame = f"\nBase frame: {arm['base_frame']}.\n" if arm["base_frame"] else ""
    return f"\n## {arm['title']}\n\n{table}{frame}\nWhere the figures come from:\n\n{sources}{missing}"


def _list(value: object) -> list[Any]:
    return list(value) if isinstance(value, list | tuple) else []


def _known(value: object) -> str:
    return "-" if value is None else f"{value:g}"


def command_line() -> str:
    """Every command with its arguments and options, read from the application itself, in the groups of its help."""
    root: Any = typer.main.get_command(app)
    text, group = "", ""
    for name, command in root.commands.items():
        if command.rich_help_panel != group:
            group = command.rich_help_panel
            text += f"\n## {group}\n"
        text += _command(name, command)
    return text


def _command(name: str, command: Any) -> str:
    arguments = [item for item in command.params if item.param_type_name == "argument"]
    options = [item for item in command.params if item.param_type_name == "option" and "--help" not in item.opts]
    words = [_argument(item) for item in arguments] + (["[OPTIONS]"] if options else [])
    rows = [(f"`{_argument(item)}`", item.help or "") for item in arguments]
    rows += [(f"`{_option(item)}`", item.help or "") for item in options]
    usage = f"```console\n$ nospill {' '.join([name, *words])}\n```\n"
    table = markdown_table(("argument", "meaning"), rows) if rows else ""
    return f"\n### nospill {name}\n\n{' '.join((command.help or '').split())}\n\n{usage}\n{table}"


def _argument(item: Any) -> str:
    word = item.metavar or item.name.upper()
    return word if item.required else f"[{word}]"


def _option(item: Any) -> str:
    names = ", ".join([*item.opts, *item.secondary_opts])
    return names if item.is_flag else f"{names} {item.metavar or item.name.upper()}"


def examples_table() -> str:
    """Name, scenario file and one line about every bundled example."""
    data = "../../src/nospill/scenario/data"
    rows = [(f"[`{name}`]({data}/{name}.toml)", f"{about[:1].upper()}{about[1:]}.") for name, about in EXAMPLES.items()]
    return markdown_table(("example", "what it shows"), rows)


TABLES: dict[str, Callable[[], str]] = {
    "command-line": command_line,
    "constraints": constraints_table,
    "examples": examples_table,
    "exporters": exporters_table,
    "interfaces": interfaces_table,
    "liquids": liquids_table,
    "receivers": receivers_table,
    "robots": robots_page,
    "shapes": shapes_table,
}
"""Name of a table in a page -> what writes it."""
