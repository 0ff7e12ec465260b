"""Plans of the bundled examples that the tests have made, for the documentation to draw: out/example-plans."""

from __future__ import annotations

import hashlib
import shutil
from functools import cache
from pathlib import Path

from nospill.plans.plan import Plan

REPOSITORY = Path(__file__).parents[1]
FOLDER = REPOSITORY / "out" / "example-plans"


@cache
def _digest() -> str:
    """Of every file of the package that is no compiled one."""
    package, digest = REPOSITORY / "src" / "nospill", hashlib.sha256()
    for path in sorted(package.rglob("*")):
        if path.is_file() and "__pycache__" not in path.parts:
            digest.update(f"{path.relative_to(package)}\0".encode() + path.read_bytes())
    return digest.hexdigest()[:16]


def keep(plan: Plan, name: str) -> None:
    """Save the plan of an example in the place of one that another state of the package has made."""
    place = FOLDER / name / _digest()
    if not place.is_dir():
        shutil.rmtree(place.parent, ignore_errors=True)
        plan.with_second_looks().save(place)


def kept(name: str) -> Path | None:
    """The plan folder of an example, without figures; None where this state of the package has made none."""
    place = FOLDER / name / _digest()
    return place if place.is_dir() else None
