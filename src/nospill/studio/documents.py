"""Opening, saving and handing out: scenario files in one folder, uploads and downloads through the browser.

A browser names scenarios, never paths: who can reach the studio writes scenario files in its folder and nothing else.
"""

from __future__ import annotations

import io
import os
import re
import tempfile
import tomllib
import zipfile
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from nospill.errors import ScenarioError
from nospill.export import EXPORTERS
from nospill.plans.handover import exporter_named, hand_over
from nospill.plans.plan import Plan
from nospill.scenario import read_scenario, scene_from_table
from nospill.scenario.examples import EXAMPLES
from nospill.scene.scene import Scene
from nospill.studio.defaults import default_of
from nospill.studio.fields import Field

START = "pp-two-cups"
"""The example a studio opens with when no scenario is named."""

PLAN_FOLDER = "plan folder"
"""The choice beside the exporters: everything that `nospill plan -o` writes."""

NAME = Field(("name",), "Save as", "text", (), "name of the scenario, and of its file", default_of(("name",)))
"""The field of the scenario's name."""

_LARGEST_UPLOAD = 10_000_000
_MOST_FILES = 200
_FILE_NAME = re.compile(r"[A-Za-z0-9_-]{1,64}", re.ASCII)


@dataclass(frozen=True, slots=True)
class Download:
    """A file for the browser: its name, its content, and one line about it."""

    name: str
    content: bytes
    message: str


def scenario_choices(folder: Path) -> tuple[str, ...]:
    """What can be opened: the bundled examples, then the scenario files of a folder."""
    try:
        files = sorted(entry.name for entry in os.scandir(folder) if entry.name.endswith(".toml") and _scenario(entry))
    except OSError:
        files = []
    return (*EXAMPLES, *files[:_MOST_FILES])


def _scenario(entry: os.DirEntry[str]) -> bool:
    """Whether a file has the tables of a scenario; what they hold is checked when it is opened."""
    try:
        if not entry.is_file() or entry.stat().st_size > _LARGEST_UPLOAD:
            return False
        table = tomllib.loads(Path(entry.path).read_text(encoding="utf-8-sig"))
    except (OSError, ValueError, RecursionError):
        return False
    return {"robot", "tray"} <= table.keys()


def open_scenario(choice: str, folder: Path) -> dict[str, Any]:
    """The table of a scenario, with the files it names read in.

    Args:
        choice: one of `scenario_choices`.
        folder: of the scenario files.

    Raises:
        ScenarioError: it is no choice, or the reader refuses it.
    """
    if choice not in scenario_choices(folder):
        raise ScenarioError(f"{choice}: no scenario of that name in {folder}")
    return read_scenario(choice if choice in EXAMPLES else folder / choice).source


def read_upload(name: str, content: bytes) -> dict[str, Any]:
    """The table of a scenario file that came from the browser.

    Raises:
        ScenarioError: it is no scenario, or it names other files, which did not come with it.
    """
    stem = Path(name).stem
    if len(content) > _LARGEST_UPLOAD:
        raise ScenarioError(f"{name}: is too large for a scenario ({len(content)} bytes)")
    try:
        table = tomllib.loads(content.decode("utf-8-sig"))
    except (UnicodeDecodeError, tomllib.TOMLDecodeError, ValueError, RecursionError) as error:
        raise ScenarioError(f"{name}: is not a scenario file: {error}") from None
    for place, key in (("robot", "urdf"), ("path", "file")):
        part = table.get(place)
        if isinstance(part, dict) and key in part:
            raise ScenarioError(
                f"{name}: [{place}]: {key} names another file, which an upload does not bring; "
                "start the studio with this file instead: nospill studio FILE"
            )
    return scene_from_table(table, name=stem).source


def save_scenario(scene: Scene, folder: Path) -> Path:
    """Write a scenario into the folder, under its name.

    Raises:
        PlanFolderError: the disk refuses.
    """
    if not _FILE_NAME.fullmatch(scene.name):
        raise ScenarioError(f"{scene.name}: is no name for a file; use letters, digits, - and _")
    path = folder / f"{scene.name}.toml"
    scene.save(path)
    return path


def scenario_download(scene: Scene) -> Download:
    """The scenario as the browser saves it."""
    return Download(f"{scene.name}.toml", scene.text().encode(), f"{scene.name}.toml handed to the browser")


def export_choices() -> tuple[str, ...]:
    """What a plan can be handed out as."""
    return (PLAN_FOLDER, *EXPORTERS)


def export_plan(plan: Plan, choice: str, *, rate: float | None = None) -> Download:
    """A plan in one format, judged as its receiver plays it; folders come as a zip file.

    Args:
        plan: the plan.
        choice: one of `export_choices`.
        rate: samples per second, Hz; the plan's when left out.

    Raises:
        ScenarioError: the format does not take this scene.
        PlanFolderError: the disk refuses.
    """
    name = plan.scene.name
    with tempfile.TemporaryDirectory(prefix="nospill-studio-") as work:
        if choice == PLAN_FOLDER:
            target = Path(work) / name
            plan.save(target)
            return Download(f"{name}.zip", _zip(target), f"{name}.zip: {plan.message}")
        exporter = exporter_named(choice)
        target = Path(work) / f"{name}{exporter.suffixes[0]}"
        done = hand_over(plan, exporter, target, rate=rate)
        verdict = f"{done.certificate.word} as its receiver plays it"
        message = f"{target.name}: {done.samples} samples at {done.rate:.6g} Hz, {verdict}"
        if target.is_dir():
            return Download(f"{target.name}.zip", _zip(target), message)
        return Download(target.name, target.read_bytes(), message)


def _zip(folder: Path) -> bytes:
    content = io.BytesIO()
    with zipfile.ZipFile(content, "w", zipfile.ZIP_DEFLATED) as archive:
        for file in sorted(folder.rglob("*")):
            if file.is_file():
                archive.write(file, Path(folder.name) / file.relative_to(folder))
    return content.getvalue()
