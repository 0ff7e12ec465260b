"""To which order the heights of a scene's liquids are judged, in words: none is linear silently."""

from __future__ import annotations

from nospill.laws.constraints.residual_height import ResidualHeight
from nospill.laws.constraints.slosh_height import SloshHeight
from nospill.scene.heights import by_nonlinear_flow, linear_since, to_second_order
from nospill.scene.scene import Scene

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
    orders = height_orders(scene)
    titles = {cargo.name: cargo.title for cargo in scene.cargo}
    alike: dict[str, list[str]] = {}
    for name, order in orders.items():
        if order != SECOND:
            alike.setdefault(order, []).append(titles[name])
    return "; ".join(f"{SloshHeight.name}{_of(names, len(orders))}: {order}" for order, names in alike.items())


def flow_note(scene: Scene) -> str:
    """Whose heights are judged by the nonlinear flow, where the scenario asks for it; empty elsewhere.

    "slosh height and residual height by the nonlinear flow: cup, mug; others to the second order".
    """
    rules = scene.motion
    asked = [(SloshHeight.name, rules.slosh_height), (ResidualHeight.name, rules.residual_height)]
    which = " and ".join(name for name, order in asked if order == "nonlinear")
    if scene.fidelity != "full" or not which:
        return ""
    found = [] if rules.stop else [item for item in scene.cargo if by_nonlinear_flow(item, "nonlinear")]
    if not found:
        return f"{which}: of no liquid by the nonlinear flow, which is of upright cups that begin at rest"
    names, liquids = [item.title for item in found], height_orders(scene)
    others = "; others to the second order" if len(found) < len(liquids) else ""
    more = f" and {len(names) - _NAMED} more" if len(names) > _NAMED else ""
    return f"{which} by the nonlinear flow: {', '.join(names[:_NAMED])}{more}{others}"


def height_sentence(scene: Scene) -> str:
    """The same as a sentence to be put behind others, with the space before it."""
    note = height_note(scene)
    return f" {note[:1].upper()}{note[1:]}." if note else ""


def _of(names: list[str], count: int) -> str:
    if len(names) == count:
        return ""
    more = f" and {len(names) - _NAMED} more" if len(names) > _NAMED else ""
    return f" of {', '.join(names[:_NAMED])}{more}"
