"""A small cycle for tests: two cups out, one taken off, one back."""

from __future__ import annotations

from functools import cache
from typing import Any

import nospill as ns
from nospill.plans.cycle import CyclePlan


def there_and_back(**legs: dict[str, Any]) -> dict[str, Any]:
    """The table of the cycle, with other keys for its legs, by name ("out", "back")."""
    cups = [
        {
            "name": name,
            "at": [x, 0.0],
            "shape": "cylinder",
            "radius": "40 mm",
            "height": "95 mm",
            "liquid": "water",
            "liquid_height": "60 mm",
            "max_slosh_height": "8 mm",
            "empty_mass": "0.3 kg",
        }
        for name, x in (("near", -0.07), ("far", 0.07))
    ]
    out = {
        "name": "out",
        "path": {"type": "line", "start": [0.6, -0.25, 0.5], "end": [0.6, 0.25, 0.5]},
        "dwell": "0.3 s",
        "unload": ["far"],
    }
    back: dict[str, Any] = {"name": "back", "path": {"type": "line"}, "dwell": 0.2}
    return {
        "name": "there-and-back",
        "fidelity": "deliverable",
        "robot": {"model": "ur10e"},
        "tray": {"size": ["400 mm", "300 mm"], "friction": 0.4, "mass": "0.5 kg", "offset": "50 mm"},
        "cargo": cups,
        "motion": {"residual_fraction": 0.8},
        "leg": [{**leg, **legs.get(str(leg["name"]), {})} for leg in (out, back)],
    }


@cache
def small_plan() -> CyclePlan:
    """Its plan, made once."""
    return ns.plan_cycle(there_and_back())
