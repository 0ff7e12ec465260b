"""To which order the heights of a scene's liquids are judged, in words: none is linear silently."""

from __future__ import annotations

from nospill.laws.constraints.residual_height import ResidualHeight
from nospill.laws.constraints.slosh_height import SloshHeight
from nospill.scene.heights import by_nonlinear_flow, linear_since, to_second_order
from nospill.scene.scene import Scene
from nospill.scene.variants import liquid_offsets

SECOND = "second order"
_LINEAR, _NAMED = "linear, since ", 4


def height_orders(scene: Scene) -> dict[str, str]:
    """Of every liquid with an open surface "second order", or "linear, since ..." with the reason; by object."""
    motion, found = scene.motion, dict[str, str]()
    for cargo in scene.cargo:
        if cargo.filling is None or cargo.filling.lid:
            continue
        if scene.fidelity != "full":
            found[cargo.name] = f"{_LINEAR}the published physics are"
        elif to_second_order(cargo, motion.slosh_height):
            found[cargo.name] = SECOND
        else:
            stated = motion.slosh_height == "linear" and (motion.linear_since or "motion.slosh_height says so")
            found[cargo.name] = _LINEAR + (stated or linear_since(cargo) or "")
    return found


def height_note(scene: Scene) -> str:
    """Which heights are linear at full fidelity and why, in one line; empty where none is.

    "slosh height of soup, white, red: linear, since the flow is known in upright cylinders and boxes only".
    """
    if scene.fidelity != "full":
        return ""
    orders, residual = height_orders(scene), scene.motion.residual_height != "linear" and not scene.motion.stop
    heights = f"{SloshHeight.name} and {ResidualHeight.name}" if residual else SloshHeight.name
    titles = {cargo.name: cargo.title for cargo in scene.cargo}
    alike: dict[str, list[str]] = {}
    for name, order in orders.items():
        if order != SECOND:
            alike.setdefault(order, []).append(titles[name])
    return "; ".join(f"{heights}{_of(names, len(orders))}: {order}" for order, names in alike.items())


def flow_note(scene: Scene) -> str:
    """Whose heights after the end are judged by the nonlinear flow, where the scenario asks for it; empty elsewhere.

    "residual height by the nonlinear flow: cup, mug; others as their slosh heights".
    """
    rules = scene.motion
    if scene.fidelity != "full" or rules.residual_height != "nonlinear":
        return ""
    found = [] if rules.stop else [c for c in scene.cargo if by_nonlinear_flow(c, rules.slosh_height, "nonlinear")]
    if not found:
        return f"{ResidualHeight.name}: of no liquid by the nonlinear flow, which is of upright cups that begin at rest"
    names, liquids = [item.title for item in found], height_orders(scene)
    others = "; others as their slosh heights" if len(found) < len(liquids) else ""
    if rules.speed_range is not None:
        others += "; at other speeds than planned to the second order"
    if any(offset.frequency for item in found for offset in liquid_offsets(item)):
        others += "; at other frequencies than stated to the second order"
    more = f" and {len(names) - _NAMED} more" if len(names) > _NAMED else ""
    return f"{ResidualHeight.name} by the nonlinear flow: {', '.join(names[:_NAMED])}{more}{others}"


def height_sentence(scene: Scene) -> str:
    """The same as a sentence to be put behind others, with the space before it."""
    note = height_note(scene)
    return f" {note[:1].upper()}{note[1:]}." if note else ""


def _of(names: list[str], count: int) -> str:
    if len(names) == count:
        return ""
    more = f" and {len(names) - _NAMED} more" if len(names) > _NAMED else ""
    return f" of {', '.join(names[:_NAMED])}{more}"
