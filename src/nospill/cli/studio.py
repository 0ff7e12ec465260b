"""studio: lay out, plan and change a scenario in the browser."""

from __future__ import annotations

import threading
import webbrowser
from contextlib import suppress
from pathlib import Path
from typing import Annotated

import typer


def studio(
    scenario: Annotated[
        str | None,
        typer.Argument(metavar="SCENARIO", help="A scenario file, or the name of an example.", show_default=False),
    ] = None,
    port: Annotated[
        int, typer.Option("--port", min=0, max=65535, help="Port; the next free one if it is taken.")
    ] = 8080,
    host: Annotated[
        str,
        typer.Option(
            "--host", help="Address to listen on; others than this machine's own let in everybody who can reach it."
        ),
    ] = "127.0.0.1",
    no_browser: Annotated[bool, typer.Option("--no-browser", help="Only print the address.")] = False,
) -> int:
    """Lay out a tray in the browser, plan, watch, change and plan again, save."""
    from nospill.viewer.library import require_viser

    require_viser()
    from nospill.scenario import read_scenario
    from nospill.scenario.examples import EXAMPLES
    from nospill.studio.documents import START

    table = read_scenario(scenario or START).source
    own_file = scenario is not None and (scenario not in EXAMPLES or Path(scenario).is_file())
    folder = Path(scenario).resolve().parent if scenario is not None and own_file else Path.cwd()
    from nospill.studio.server import studio as running

    with suppress(KeyboardInterrupt), running(table, folder=folder, port=port, host=host) as address:
        print(f"{address}  (stop with Ctrl-C)", flush=True)
        if not no_browser:
            webbrowser.open(address)
        threading.Event().wait()
    return 0
