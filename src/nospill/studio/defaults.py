"""What holds where a field is empty, in words short enough for the field itself."""

from __future__ import annotations

import re
from functools import cache

from nospill.scenario.reference import default_text, sections
from nospill.scenario.scenes import scenario_schema
from nospill.studio.draft import Key

_TABLE = re.compile(r"(?:Every )?`\[+([\w.]+)\]+`")
_NO_VALUE = ("-", "**required**", "0 rad")
_MEANT: dict[tuple[str, str], str] = {
    ("", "name"): "the file's name",
    ("robot.limits", "speed_scale"): "1",
    ("motion", "duration"): "the shortest",
    ("motion", "max_jerk"): "2000 m/s^3",
    ("motion", "path_jerk_limit"): "from max jerk",
    ("cargo", "friction"): "the tray's",
    ("cargo", "max_slosh_height"): "to the rim less a reserve",
    ("cargo", "mass"): "of its parts",
    ("cargo", "centre_of_mass_height"): "from its sizes",
    ("cargo", "liquid_height"): "from the volume",
    ("cargo", "liquid_volume"): "from the height",
    ("cargo", "empty_mass"): "from the mass",
    ("cargo", "wall"): "none",
    ("cargo", "base_radius"): "the flat bottom",
    ("cargo", "base_inner_radius"): "a disc",
    ("cargo", "label"): "the name",
}
"""What an absent key means where the schema has no value for it, by table and key."""


def default_of(key: Key) -> str:
    """What an empty field at a place of the table stands for; empty where its key is required or has no default."""
    names = [part for part in key if isinstance(part, str)]
    place = (".".join(names[:-1]), names[-1])
    unlimited = "none" if place[0] == "motion" else ""
    return _MEANT.get(place) or _values().get(place, unlimited)


@cache
def all_keys() -> frozenset[str]:
    """Every key of a scenario file, whatever its table."""
    return frozenset(name for section in sections(scenario_schema()) for name in section.rows)


@cache
def _values() -> dict[tuple[str, str], str]:
    """Defaults that are values, by table and key, as the page of all keys has them."""
    schema, defaults = scenario_schema(), {}
    for section in sections(schema):
        match = _TABLE.match(section.place)
        table = match[1] if match else ""
        for name, value in section.rows.items():
            text = default_text(name, value, section.required)
            if text not in _NO_VALUE:
                defaults[table, name] = text.strip("`").strip('[]"')
    return defaults
