"""Plans of the bundled examples that the tests have made, for other tests and the documentation: out/example-plans.

A plan is kept as long as the package stays as it is: planned again, it would be the same.
"""

from __future__ import annotations

import hashlib
import pickle
import shutil
import sys
from collections.abc import Callable
from functools import cache
from pathlib import Path

from filelock import FileLock

from nospill.plans.plan import Plan

REPOSITORY = Path(__file__).parents[1]
FOLDER = REPOSITORY / "out" / "example-plans"


@cache
def _digest() -> str:
    """Of every file of the package that is no compiled one, of the pins of what it uses, and of Python's version."""
    package, pins = REPOSITORY / "src" / "nospill", (REPOSITORY / "constraints.txt").read_bytes()
    digest = hashlib.sha256(f"{sys.version}\0".encode() + pins)
    for path in sorted(package.rglob("*")):
        if path.is_file() and "__pycache__" not in path.parts:
            digest.update(f"{path.relative_to(package)}\0".encode() + path.read_bytes())
    return digest.hexdigest()[:16]


def planned_once(name: str, planned: Callable[[], Plan]) -> Plan:
    """The plan of an example with its judgement: of this state of the package, by whichever process came first.

    Args:
        name: of the example.
        planned: makes the plan where there is none; what another state of the package has made is removed.
    """
    place = FOLDER / name / _digest()
    whole = place.with_suffix(".pickle")
    FOLDER.mkdir(parents=True, exist_ok=True)
    with FileLock(FOLDER / f"{name}.lock"):
        if not whole.is_file():
            made = planned()
            shutil.rmtree(place.parent, ignore_errors=True)
            made.with_second_looks().save(place)
            whole.write_bytes(pickle.dumps(made))
        return pickle.loads(whole.read_bytes())


def kept(name: str) -> Path | None:
    """The plan folder of an example, without figures; None where this state of the package has made none."""
    place = FOLDER / name / _digest()
    return place if place.is_dir() else None
