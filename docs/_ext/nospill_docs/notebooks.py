"""Notebooks executed by the build and turned into pages: text as it is, code with what it printed and drew."""

from __future__ import annotations

import base64
from pathlib import Path
from typing import Any

# Imported here, before any thread: looking up a kernel imports IPython, and matplotlib, drawing in another thread,
# reads IPython's version as soon as the import of it has begun.
import IPython  # noqa: F401
import nbclient
import nbformat

from nospill_docs.environment import once_for_a_page
from nospill_docs.places import Places, copy_if_changed, write_if_changed

TIME_LIMIT = 120
"""Seconds that one cell may take."""


def write_notebooks(places: Places) -> None:
    """One page a notebook of docs/notebooks; executed only when it or the package has changed."""
    for source in sorted((places.docs / "notebooks").glob("*.ipynb")):
        text = source.read_text(encoding="utf-8")
        made = places.cached(f"notebook-{source.stem}", text, lambda folder, text=text: _make(text, folder))
        for picture in sorted(made.glob("*.png")):
            copy_if_changed(picture, source.parent / "pictures" / source.stem / picture.name)
        page = (made / "page.md").read_text(encoding="utf-8").replace("@pictures@", f"pictures/{source.stem}")
        write_if_changed(source.with_suffix(".md"), page)


def execute(text: str, folder: Path) -> Any:
    """Run a notebook from top to bottom in a process of its own and return it with its outputs.

    Args:
        text: the notebook as it is kept, without outputs.
        folder: where it runs.

    Raises:
        nbclient.exceptions.CellExecutionError: a cell failed.
    """
    notebook = nbformat.reads(text, as_version=4)
    client = nbclient.NotebookClient(
        notebook,
        timeout=TIME_LIMIT,
        coalesce_streams=True,
        extra_arguments=["--log-level=ERROR"],
        resources={"metadata": {"path": str(folder)}},
    )
    return client.execute(env=once_for_a_page())


def _make(text: str, folder: Path) -> None:
    page, pictures = to_markdown(execute(text, folder))
    for name, content in pictures.items():
        (folder / name).write_bytes(content)
    (folder / "page.md").write_text(page, encoding="utf-8")


def to_markdown(notebook: Any) -> tuple[str, dict[str, bytes]]:
    """An executed notebook as a MyST page, and its pictures by name; the page finds them in `@pictures@`."""
    parts: list[str] = []
    pictures: dict[str, bytes] = {}
    for cell in notebook.cells:
        if cell.cell_type == "markdown":
            parts.append(cell.source)
            continue
        parts.append(_fenced("python", cell.source))
        for output in cell.outputs:
            data = output.get("data", {})
            if output.output_type == "stream":
                parts.append(_fenced("text", output.text.rstrip()))
            elif "image/png" in data:
                name = f"figure-{len(pictures) + 1}.png"
                pictures[name] = base64.b64decode(data["image/png"])
                parts.append(f"![output of the cell above](@pictures@/{name})")
            elif "text/plain" in data:
                parts.append(_fenced("text", data["text/plain"].rstrip()))
    return "\n\n".join(parts) + "\n", pictures


def _fenced(language: str, text: str) -> str:
    return f"```{language}\n{text}\n```"
