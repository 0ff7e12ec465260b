"""What a cluster's workers must have, and what they are given: versions, compiled functions."""

from __future__ import annotations

import io
import os
import zipfile
from importlib import metadata
from typing import Any

from distributed import Client
from distributed.diagnostics.plugin import WorkerPlugin

from nospill import __version__
from nospill.compiled.cache_folder import cache_folder, is_private, mode
from nospill.compiled.entries import current_files
from nospill.errors import ClusterError

_ASKED = "__import__('nospill').__version__"


def require_alike(client: Client, address: str, *, patience: float) -> None:
    """Wait for a worker, and compare versions.

    Args:
        client: of the cluster.
        address: of its scheduler, for messages.
        patience: s to wait for the first worker.

    Raises:
        ClusterError: no worker comes, or scheduler or worker have no nospill or another version of it or of Dask.
    """
    try:
        client.wait_for_workers(1, timeout=patience)
    except TimeoutError:
        raise ClusterError(
            f"--scheduler {address}: has no worker; start some with `dask worker {address} --nthreads 1`"
        ) from None
    theirs: Any = client.get_versions(check=False)  # a coroutine of an asynchronous client alone
    here = metadata.version("distributed")
    parts = {"the scheduler": theirs["scheduler"]} | {f"worker {name}": one for name, one in theirs["workers"].items()}
    for who, found in parts.items():
        version = ((found or {}).get("packages") or {}).get("distributed")
        if version not in (None, here):
            raise ClusterError(
                f"--scheduler {address}: {who} has distributed {version}, here is {here}; install the same on all"
            )
    # `eval` is known to a worker that lacks the package, where a function of ours is not.
    answers: Any = client.run(eval, _ASKED, on_error="return")
    for who, found in answers.items():
        if found != __version__:
            what = f"nospill {found}" if isinstance(found, str) else "no nospill"
            raise ClusterError(
                f"--scheduler {address}: worker {who} has {what}, here is {__version__}; install nospill "
                f"{__version__} there"
            )


class CompiledFunctions(WorkerPlugin):
    """Compiled functions of the machine that started the sweep, in the cache of every worker's machine.

    They are found there by the same key, which names source, versions and processor: one that does not fit is not used.
    """

    name = "nospill compiled functions"

    def __init__(self, archive: bytes) -> None:
        """Of files of the cache, as a ZIP archive."""
        self._archive = archive

    def setup(self, worker: Any) -> None:
        """Unpack what is not there; called once a worker."""
        unpack(self._archive)


def sent_functions() -> CompiledFunctions:
    """What this machine has compiled."""
    content = io.BytesIO()
    with zipfile.ZipFile(content, "w", zipfile.ZIP_DEFLATED) as archive:
        for file in current_files():
            archive.write(file, file.name)
    return CompiledFunctions(content.getvalue())


def unpack(archive: bytes) -> None:
    """Put files into this machine's cache of compiled functions; those of a library before it, as who looks expects.

    Nothing is written where compilation is switched off or others may write to the cache.
    """
    folder = cache_folder()
    if mode() == "off":
        return
    folder.mkdir(parents=True, exist_ok=True, mode=0o700)
    if not is_private(folder):
        return
    with zipfile.ZipFile(io.BytesIO(archive)) as files:
        for name in sorted(files.namelist(), key=lambda name: (name.endswith(".so"), name)):
            place = folder / os.path.basename(name)
            if not place.exists():
                partial = place.with_name(f"{place.name}.{os.getpid()}.tmp")
                partial.write_bytes(files.read(name))
                partial.replace(place)
