"""cache: the compiled functions on the disk."""

from __future__ import annotations

from typing import Annotated

import typer

from nospill.cli.progress import ProgressLine
from nospill.cli.reporting import STOPPED
from nospill.cli.tables import print_table


def cache(
    warm: Annotated[
        bool, typer.Option("--warm", help="Compile what plans usually need: takes minutes, may be interrupted.")
    ] = False,
    clear: Annotated[bool, typer.Option("--clear", help="Remove everything.")] = False,
) -> int:
    """List, fill or empty the cache of compiled functions."""
    from nospill.compiled.entries import clear_cache

    if clear:
        print(f"{clear_cache()} files removed")
    code = _warm() if warm else 0
    if warm or not clear:
        _list()
    return code


def _warm() -> int:
    from nospill.warmup.warming import warm_cache

    try:
        with ProgressLine() as progress:
            warm_cache(progress=progress.say)
    except KeyboardInterrupt:
        return STOPPED
    return 0


def _list() -> None:
    from nospill.compiled.cache_folder import cache_folder
    from nospill.compiled.entries import cache_entries

    entries = cache_entries()
    groups = {kind: [entry for entry in entries if entry.kind == kind] for kind in sorted({e.kind for e in entries})}
    rows = [
        (name, len(part), sum(not entry.current for entry in part), f"{sum(entry.size for entry in part) / 1e6:.1f}")
        for name, part in {**groups, "all": list(entries)}.items()
    ]
    print_table(("functions", "entries", "of another version", "MB"), rows)
    print(f"folder: {cache_folder()}")
