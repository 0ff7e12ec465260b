"""Judging the plan of a cycle again: each leg by the cycle's own scenario and by what the leg before it leaves."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any

from nospill.core.units import as_written
from nospill.errors import ScenarioError
from nospill.plans.approach import judge_whole
from nospill.plans.cycle import CycleCertificate, CyclePlan, seams
from nospill.plans.plan import Plan
from nospill.plans.row_checks import require_in_a_row
from nospill.plans.rows import swinging_after
from nospill.scene.cycle import CycleLeg
from nospill.scene.scene import Scene

_CHOSEN = ("start", "goal", "start_joints", "way", "way_yaw", "way_joints")
"""Keys of a path that planning fills in: its ends are compared as places."""
_SAME = 1e-6
"""m, m/s, or part of a number: what is nearer is the same."""


def judge_cycle(plan: CyclePlan) -> CyclePlan:
    """Judge a cycle again: its motions, dwells and seams, from the samples and the cycle's scenario alone.

    Raises:
        ScenarioError: a leg is of another arm, tray or place than the one before it.
        PlanFolderError, ModelError: as for `certificate.certify`.
    """
    judged: list[Plan] = []
    changed: list[str] = []
    for leg, saved in zip(plan.cycle.legs, plan.legs, strict=True):
        scene = leg_scene(leg, judged[-1] if judged else None, saved.scene)
        changed += [f'leg "{leg.name}": {fault}' for fault in differences(scene.source, saved.scene.source)][:1]
        found = judge_whole(replace(saved, scene=scene))
        judged.append(replace(saved, scene=scene, certificate=found.certificate, judgement=found))
    named = [(leg.name, one) for leg, one in zip(plan.cycle.legs, judged, strict=True)]
    own = tuple((name, one.certificate) for name, one in named)
    certificate = CycleCertificate(own, seams(named), (*plan.certificate.changed, *changed))
    return CyclePlan(plan.cycle, tuple(judged), certificate)


def leg_scene(leg: CycleLeg, before: Plan | None, planned: Scene | None = None) -> Scene:
    """The scene of a leg as it is judged: of the cycle, with the swing that is left, on the way that was planned.

    Raises:
        ScenarioError: the planned way leads elsewhere, or arm, tray or an object is another one than before.
    """
    scene = leg.scene
    if planned is not None:
        path, given = dict(scene.source["path"]), planned.source["path"]
        path |= {key: given[key] for key in _CHOSEN if key in given and (key in path or _is_chosen(key, path))}
        scene = scene.changed({"path": path})
        for s, word in ((0.0, "begins"), (1.0, "ends")):
            apart = abs(scene.path.at([s])[0] - leg.scene.path.at([s])[0])
            if max(apart[:3]) > 1e-3 or abs(math.remainder(apart[3], math.tau)) > math.radians(0.5):
                raise ScenarioError(f'leg "{leg.name}": its way {word} elsewhere than the cycle says; plan it again')
    if before is None:
        return scene
    require_in_a_row(scene, before)
    return swinging_after(scene, before, 0.0)


def _is_chosen(key: str, path: Mapping[str, Any]) -> bool:
    return key.startswith("way") if path["type"] == "free" else key == "start_joints"


def differences(wanted: Mapping[str, Any], found: Mapping[str, Any]) -> list[str]:
    """What the scenario of a leg says otherwise than the cycle's, a phrase for each key."""
    ours, theirs = dict(_flat(wanted)), dict(_flat(found))
    phrases: list[str] = []
    for key in sorted(ours.keys() | theirs.keys()):
        one, other = ours.get(key), theirs.get(key)
        if not _alike(one, other):
            said = "missing" if other is None else as_written(other)
            phrases.append(f"{key} is {said} in its folder and {as_written(one)} by the cycle and the leg before")
    return phrases


def _flat(value: Any, place: str = "") -> Iterator[tuple[str, Any]]:
    if isinstance(value, Mapping):
        for key, entry in value.items():
            yield from _flat(entry, f"{place}.{key}" if place else str(key))
    elif isinstance(value, Sequence) and not isinstance(value, str):
        for index, entry in enumerate(value):
            name = entry.get("name", index) if isinstance(entry, Mapping) else index
            yield from _flat(entry, f"{place}.{name}")
    else:
        yield place, value


def _alike(one: Any, other: Any) -> bool:
    if isinstance(one, int | float) and isinstance(other, int | float):
        return math.isclose(one, other, rel_tol=_SAME, abs_tol=_SAME)
    return one == other
