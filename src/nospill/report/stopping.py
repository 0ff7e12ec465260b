"""What a report says of stops: the table that `nospill stops` left in the plan folder, if it is of this plan."""

from __future__ import annotations

from pathlib import Path

from nospill.core.files import parsed_json
from nospill.errors import PlanFolderError
from nospill.plans.names import STOPS_FILE
from nospill.plans.plan import Plan
from nospill.plots.text_pages import TextTable

_TITLE = "If it is stopped"
_COLUMNS = ("at [s]", "spill-free stop [s]", "rest of the plan [s]", "each joint braked", "time scaled to zero")
_ROWS = 12
"""Instants that are listed."""
_SAME = 1e-6
"""s, by which the duration of the plan of the table may differ."""


def read_stopping_table(folder: str | Path, plan: Plan) -> TextTable | None:
    """The stops of a plan beside what the controller's own stop does; None where nobody has looked for them.

    Raises:
        PlanFolderError: the record cannot be read.
    """
    path = Path(folder) / STOPS_FILE
    if not path.is_file():
        return None
    try:
        record = parsed_json(path.read_text(encoding="utf-8-sig"))
        if abs(float(record["duration_s"]) - plan.duration) > _SAME:
            return TextTable(_TITLE, (), (("The stops in this folder are of another plan: nospill stops DIR.",),))
        own = {(float(item["t_s"]), str(item["kind"])): str(item["text"]) for item in record["controller"]}
        stops = [(float(item["t_s"]), float(item["stops_in_s"]), float(item["left_s"])) for item in record["stops"]]
        rows = tuple(
            (f"{t:.2f}", f"{takes:.3f}", f"{left:.3f}", own[t, "joints"], own[t, "path"])
            for t, takes, left in stops[:: -(-len(stops) // _ROWS)]
        )
        longest = record["longest_stop"]
        note = (
            f"The longest of {len(stops)} spill-free stops takes {float(longest['stops_in_s']):.3f} s, from "
            f"{float(longest['t_s']):.2f} s. They are motions, and no safety function."
        )
    except (OSError, ValueError, KeyError, TypeError) as error:
        raise PlanFolderError(
            f"{path}: damaged ({error!r}); delete it or write it again with nospill stops DIR"
        ) from error
    return TextTable(_TITLE, _COLUMNS, rows, note=note)
