"""The libraries in C: their source, and how they are compiled.

A wheel carries them where a compiler was there when it was built (setup.py); otherwise they are compiled at their first
use (`compiled/small_libraries.py`). A file is named by the hash of its source, so that none outlives it.
"""

from __future__ import annotations

import hashlib
import subprocess
import sys
from functools import cache
from pathlib import Path

from nospill.native import operations

FLAGS = ("-O3", "-std=c99", "-shared", "-fPIC")
"""Of the compiler; C99 by itself contracts no products and sums."""
_OF_VECTORS = ("-ffp-contract=fast", "-Wno-psabi")
"""Of the flow besides: products and sums are fused where a processor can; no function that is called takes a vector."""

PREBUILT = Path(__file__).with_name("prebuilt")
"""Where a wheel has the compiled libraries."""

_FILES = {
    "ldl": (
        "pivot_order.c",
        "pivot_tree.c",
        "supernodes.c",
        "kept_order.c",
        "fused_products.c",
        "dense_update.c",
        "sparse_ldl.c",
    ),
    "interpreter": ("interpreter.c",),
    "flow": ("fused_products.c", "flow_vectors.c", "polar_flow.c", "polar_steps.c", "point_flow.c", "driven_waves.c"),
}
"""The files of each, compiled as one."""
LIBRARIES = tuple(_FILES)
"""Their names."""


@cache
def source(name: str) -> str:
    """The C source of a library of `LIBRARIES`."""
    parts = [Path(__file__).with_name(file).read_text(encoding="utf-8") for file in _FILES[name]]
    return "\n".join([*([operations.interpreted()] if name == "interpreter" else []), *parts])


def flags(name: str) -> tuple[str, ...]:
    """Of the compiler, for a library."""
    return (*FLAGS, *_OF_VECTORS) if name == "flow" else FLAGS


def file_name(name: str) -> str:
    """Of a compiled library."""
    digest = hashlib.sha256("\0".join((*flags(name), source(name))).encode())
    return f"{name}-{digest.hexdigest()[:32]}.so"


def compile_into(folder: Path, compiler: str) -> None:
    """Compile the libraries into a folder, as a wheel carries them.

    Args:
        folder: of the package; made where it is missing.
        compiler: path of the C compiler.

    Raises:
        OSError: the compiler cannot be run.
        subprocess.CalledProcessError: it fails, and has said why.
    """
    folder.mkdir(parents=True, exist_ok=True)
    for name in LIBRARIES:
        command = [compiler, *flags(name), "-x", "c", "-", "-o", str(folder / file_name(name)), "-lm"]
        subprocess.run(command, input=source(name), text=True, check=True)


if __name__ == "__main__":
    compile_into(Path(sys.argv[1]), sys.argv[2])
