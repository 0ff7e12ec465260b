"""`ns.sweep`: many variants of a scenario, planned and certified, from Python."""

from __future__ import annotations

import os
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from nospill.planning.varied import Source
from nospill.sweeps.definition import USUAL_AGAIN, USUAL_MEMORY, USUAL_TIME, define_sweep
from nospill.sweeps.record import Sweep
from nospill.sweeps.run import OnProgress, run_sweep


def sweep(
    base: Source,
    axes: Mapping[Any, Any],
    *,
    columns: Mapping[str, str] | None = None,
    goals: Mapping[str, str] | None = None,
    samples: int | None = None,
    seed: int = 0,
    jobs: int = 1,
    scheduler: str | None = None,
    folder: str | os.PathLike[str] | None = None,
    plans: bool = False,
    time_limit: float | str = USUAL_TIME,
    memory_limit: str = USUAL_MEMORY,
    again_cold: int = USUAL_AGAIN,
    retry: bool = False,
    progress: OnProgress | None = None,
) -> Sweep:
    """Plan and certify variants of a scenario.

    Args:
        base: a scene or a cycle, or what `load` or `load_cycle` takes.
        axes: dotted key of the scenario -> list of values, or {"from": "20 mm", "to": "60 mm", "count": 9} (or step).
            A tuple of keys, which change together, -> list with one value for each. All combinations are planned.
        columns: name -> arithmetic on other columns and on the axes' last words, SI, as "3600 / duration_s".
        goals: column -> "least" or "greatest"; the first one decides what is best. Shortest where None.
        samples: draw so many points (Latin hypercube) instead of all combinations; ranges then need no count.
        seed: of the draw.
        jobs: processes at a time on this machine.
        scheduler: address of a Dask scheduler whose workers plan instead.
        folder: where a line is kept for each point, at once; points that have one there are not planned again. None:
            nowhere.
        plans: keep a plan folder of every motion too, in `folder`.
        time_limit: of one point, s or text with a unit.
        memory_limit: of one process, as "4 GB".
        again_cold: how many points planned warm are planned from nothing too, beside the best.
        retry: plan points again that ended out of time, out of memory or in a crash.
        progress: called with where the sweep stands.

    Returns:
        The sweep; a point that has no motion is a line with its reason.

    Raises:
        ScenarioError: base, axes, columns, goals or limits are no sweep; one line that says which.
        ClusterError: nobody answers at the scheduler's address, or its workers are without this version of nospill.
        MissingExtraError: a scheduler is named, and dask.distributed is not installed.
        PlanFolderError: the folder cannot be written or another run writes into it.
    """
    definition = define_sweep(
        base,
        axes,
        columns=columns,
        goals=goals,
        samples=samples,
        seed=seed,
        time_limit=time_limit,
        memory_limit=memory_limit,
        again_cold=again_cold,
    )
    place = None if folder is None else Path(folder)
    return run_sweep(
        definition, folder=place, jobs=jobs, scheduler=scheduler, plans=plans, retry=retry, progress=progress
    )
