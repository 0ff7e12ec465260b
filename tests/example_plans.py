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
    whole = _place(name)
    FOLDER.mkdir(parents=True, exist_ok=True)
    with FileLock(FOLDER / f"{name}.lock"):
        if not whole.is_file():
            made = planned()
            shutil.rmtree(whole.parent, ignore_errors=True)
            whole.parent.mkdir(parents=True)
            whole.write_bytes(pickle.dumps(made))
        return pickle.loads(whole.read_bytes())


def kept(name: str) -> Plan | None:
    """The plan of an example as it was made, without second looks; None where this state of the package has made none.

    Second looks take half as long as the plan. They are for the pages, which print them: `python -m tests.example_plans
    NAME FOLDER` writes the plan folder with them.
    """
    whole = _place(name)
    return pickle.loads(whole.read_bytes()) if whole.is_file() else None


def _place(name: str) -> Path:
    return FOLDER / name / f"{_digest()}.pickle"


if __name__ == "__main__":
    made = kept(sys.argv[1])
    assert made is not None
    made.save(sys.argv[2])
