"""The environment of processes that plan, judge or draw once for a page."""

from __future__ import annotations

import os

from tests.hasty import COMPILED, NO_COMPILER


def once_for_a_page() -> dict[str, str]:
    """One thread, and no function compiled for it: what the tests have compiled is used, the rest is interpreted.

    The tests leave the judge's functions of all examples, among others.
    The curve over nineteen speeds of one example takes a fifth of the time with compiled functions.
    """
    here = {**os.environ, "NOSPILL_THREADS": "1"}
    if not COMPILED.is_dir():
        return {**here, "NOSPILL_COMPILE": "off"}
    return {**here, "NOSPILL_COMPILE": "wait", "NOSPILL_CACHE": str(COMPILED), "CC": NO_COMPILER}
