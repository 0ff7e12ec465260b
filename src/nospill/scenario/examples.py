"""The scenarios that come with nospill, by name."""

from __future__ import annotations

from pathlib import Path

from nospill.core.suggestions import nearest
from nospill.errors import ScenarioError

EXAMPLES: dict[str, str] = {
    "matrix-liquid": "four open cups of water on a level tray, published arc and end condition",
    "matrix-rigid": "four loose solids on a tray that tilts, along the published arc",
    "matrix-liquid-soft-end": "the four cups, level; at the end the water may swing up to a fifth of its limit",
    "matrix-liquid-still": "the four cups, level; at the end the water stands exactly still",
    "matrix-liquid-tilt": "the four cups on a tray that tilts, with the whole slosh and contact model",
    "matrix-liquid-tilt-robust": "the same for ranges of friction, fill and damping: it holds at every corner",
    "matrix-liquid-tilt-all-limits": "four cups on a tilting tray, with the laboratory's limits of joint acceleration",
    "matrix-liquid-corridor": "the four cups on a tray that tilts, turns freely and leaves its arc by up to 50 mm",
    "matrix-liquid-point-to-point": "the four cups, tilting, from one end of the arc to the other on any way",
    "pp-two-cups": "two cups of water along the published path pp, level tray",
    "mixed-tray": "two cups filled differently, a box of water and a bottle on a tray that tilts",
    "coffee-to-go": "three tapered cups of coffee, filled by volume, on a UR5e that tilts its tray",
    "soup-and-wine": "a bowl of soup on its ring and two glasses of wine on their feet, on a tray that tilts",
    "vial-rack": "24 vials in a rack on a KUKA KR 6, which tilts its tray; the rack feels every liquid",
    "cups-around-a-column": "two cups of water on a UR10e that tilts, to the other side of a column, on any way",
    "shelf-to-table": "a bottle and two cups on a Franka FR3, from below the upper board of a shelf to a table",
    "bracket-tray": "two cups of water on a UR5e, on a tray that an L-bracket holds ahead of its flange",
    "cups-past-a-column": "two cups of water on a UR10e, past a column and above a table: distances are judged",
}
"""Name -> what it shows, in one line. The file of each is `scenario/data/<name>.toml`."""

CYCLES: dict[str, str] = {
    "matrix-cycle": "the four cups along the published arc, all taken off, and back with the tray empty on any way",
    "bar-service": "four glasses to four guests, one fewer after each stop, and back with the tray empty",
}
"""The same of cycles, files in `scenario/data/cycles`."""

_FOLDER = Path(__file__).parent / "data"


def example_path(name: str) -> Path:
    """The file of a bundled example.

    Raises:
        ScenarioError: no example has that name; the message lists the names.
    """
    if name in CYCLES:
        return _FOLDER / "cycles" / f"{name}.toml"
    if name not in EXAMPLES:
        near = nearest(name, EXAMPLES)
        hint = f'; did you mean "{near}"?' if near else ""
        raise ScenarioError(f'there is no bundled example "{name}" (known: {", ".join(EXAMPLES)}){hint}')
    return _FOLDER / f"{name}.toml"
