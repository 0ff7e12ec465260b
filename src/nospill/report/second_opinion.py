"""The verdict of `nospill verify`, from a simulation just made or from the record beside a plan folder."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from nospill.core.files import parsed_json
from nospill.errors import PlanFolderError
from nospill.plans.names import TRAJECTORY_FILE
from nospill.plots.text_pages import TextTable
from nospill.scene.scene import Scene

_FIGURES = ("slide_mm", "rotation_deg", "tilt_deg", "lift_off_mm")
_COLUMNS = ("object", "slide [mm]", "rotation [deg]", "tilt [deg]", "lift-off [mm]", "moves from [s]", "")


@dataclass(frozen=True, slots=True)
class SecondOpinion:
    """What a physics engine found, or why nothing is known.

    Attributes:
        ok: whether every object stays; None where there is no simulation of this plan.
        message: one sentence.
        table: figures of every object, or None.
    """

    ok: bool | None
    message: str
    table: TextTable | None = None


NOT_ASKED = SecondOpinion(None, "No simulation of this plan is at hand; nospill report DIR --verify makes one.")
"""There is no record of a simulation."""

_OLDER = SecondOpinion(None, "There is a simulation beside the folder, but it is older than the plan and not shown.")


def second_opinion(record: Mapping[str, Any]) -> SecondOpinion:
    """The verdict in a record as `nospill.verify.VerifyReport.to_dict` gives it.

    Raises:
        KeyError, TypeError, ValueError: it is no such record.
    """
    objects = record["objects"]
    rows = tuple(
        (
            str(item["name"]),
            *(f"{float(item[key]):.3g}" for key in _FIGURES),
            "" if item["moved_at_s"] is None else f"{float(item['moved_at_s']):.3f}",
            "stays" if item["ok"] else "MOVES",
        )
        for item in objects
    )
    note = (
        f"Largest movement on the tray. {record['engine']}, {float(record['simulated_s']):.2f} s simulated, joints "
        f"from {record['joints']}; an object has moved from {float(record['threshold_mm']):g} mm or "
        f"{float(record['threshold_deg']):g} deg on. Friction as measured, without its reserve."
    )
    failing = tuple(index for index, item in enumerate(objects) if not item["ok"])
    table = TextTable("A second opinion", _COLUMNS, rows, note=note, failing=failing)
    return SecondOpinion(bool(record["ok"]), str(record["message"]), table)


def read_second_opinion(folder: str | Path, scene: Scene) -> SecondOpinion:
    """The record that `nospill verify DIR --save` left beside a plan folder, if it is of this plan.

    Args:
        folder: the plan folder; the record is DIR.verify.json beside it.
        scene: of the plan, whose objects the record must name.

    Raises:
        PlanFolderError: the record cannot be read.
    """
    place = Path(folder).resolve()
    path = place.with_name(f"{place.name}.verify.json")
    if not path.is_file():
        return NOT_ASKED
    try:
        older = path.stat().st_mtime < (place / TRAJECTORY_FILE).stat().st_mtime
        record = parsed_json(path.read_text(encoding="utf-8-sig"))
        opinion = second_opinion(record)
        names = [str(item["name"]) for item in record["objects"]]
    except (OSError, ValueError, KeyError, TypeError) as error:
        again = "delete it or write it again with nospill verify DIR --save"
        raise PlanFolderError(f"{path}: damaged ({error!r}); {again}") from error
    # A copied folder loses its times, so the names are looked at too.
    return _OLDER if older or names != [item.name for item in scene.cargo] else opinion
