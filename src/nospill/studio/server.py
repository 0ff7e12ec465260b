"""The studio's server: one session for every browser tab."""

from __future__ import annotations

import socket
import threading
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

from nospill.core.units import as_written
from nospill.errors import ScenarioError
from nospill.studio.planning import PlanningSlots
from nospill.studio.session import Session
from nospill.viewer.live import running_server
from nospill.viewer.scene_view import prepare

if TYPE_CHECKING:
    import viser


@contextmanager
def studio(
    table: Mapping[str, Any],
    *,
    folder: Path,
    port: int = 8080,
    host: str = "127.0.0.1",
    sessions: dict[int, Session] | None = None,
) -> Iterator[str]:
    """A running studio: its address. Every tab starts with the same scenario and is on its own from then on.

    Args:
        table: of that scenario, without other files.
        folder: where scenario files are opened and saved.
        port: the next free one is taken where it is in use; 0 for any.
        host: address to listen on; anybody who can reach it can plan, and write scenario files in `folder`.
        sessions: filled with those that are open, by the number of the client.

    Raises:
        MissingExtraError: viser is not installed.
        ScenarioError: `host` is no address of this machine.
    """
    _require_own(host)
    seats, opened, lock = PlanningSlots(), {} if sessions is None else sessions, threading.Lock()
    with running_server(port=port, host=host) as server:
        server.gui.configure_theme(control_width="large", show_logo=False, show_share_button=False)
        prepare(server.scene)

        @server.on_client_disconnect
        def end(client: viser.ClientHandle) -> None:
            with lock:
                session = opened.pop(client.client_id, None)
            if session is not None:
                session.close()

        @server.on_client_connect
        def _(client: viser.ClientHandle) -> None:
            session = Session(client, table, folder=folder, seats=seats)
            with lock:
                opened[client.client_id] = session
            if client.client_id not in server.get_clients():  # it left while the session was built
                end(client)

        try:
            yield f"http://{f'[{host}]' if ':' in host else host}:{server.get_port()}"
        finally:
            with lock:
                left = list(opened.values())
            for session in left:
                session.close()


def _require_own(host: str) -> None:
    """Try the address: viser's own thread would fail on it, and who waits for that thread would wait for ever."""
    try:
        family = socket.getaddrinfo(host, None, type=socket.SOCK_STREAM)[0][0]
        with socket.socket(family, socket.SOCK_STREAM) as trial:
            trial.bind((host, 0))
    except (OSError, UnicodeError) as error:
        reason = getattr(error, "strerror", None) or str(error)
        raise ScenarioError(
            f"host {as_written(host)} cannot be listened on: {reason}; give an address of this machine, 127.0.0.1 for "
            "itself alone or 0.0.0.0 for all of its networks"
        ) from None
