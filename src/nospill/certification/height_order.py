"""To which order the heights of a scene's liquids are judged, in words: none is linear silently."""

from __future__ import annotations

from nospill.laws.constraints.residual_height import ResidualHeight
from nospill.laws.constraints.slosh_height import SloshHeight
from nospill.scene.heights import by_nonlinear_flow, linear_since, to_second_order
from nospill.scene.scene import Scene
from nospill.scene.variants import liquid_offsets

SECOND, BY_FLOW = "second order", "nonlinear"
_LINEAR, _NAMED = "linear, since ", 4


def height_orders(scene: Scene) -> dict[str, str]:
    """Of every liquid with an open surface "second order", "nonlinear", or "linear, since ..." with the reason."""
    motion, found = scene.motion, dict[str, str]()
    for cargo in scene.cargo:
        if cargo.filling is None or cargo.filling.lid:
            continue
        if scene.fidelity != "full":
            found[cargo.name] = f"{_LINEAR}the published physics are"
        elif to_second_order(cargo, motion.slosh_height):
            by_flow = by_nonlinear_flow(cargo, motion.slosh_height)
            found[cargo.name] = BY_FLOW if by_flow else SECOND
        else:
            stated = motion.slosh_height == "linear" and (motion.linear_since or "motion.slosh_height says so")
            found[cargo.name] = _LINEAR + (stated or linear_since(cargo) or "")
    return found


def residual_orders(scene: Scene) -> dict[str, str]:
    """The same of heights after the end."""
    motion, found = scene.motion, height_orders(scene)
    for cargo in scene.cargo:
        if found.get(cargo.name, _LINEAR).startswith(_LINEAR):
            continue
        if motion.stop:
            found[cargo.name] = f"{_LINEAR}after a stop the modes alone are judged"
        elif motion.residual_height == "linear":
            found[cargo.name] = _LINEAR + (motion.residual_linear_since or "motion.residual_height says so")
        else:
            found[cargo.name] = BY_FLOW if by_nonlinear_flow(cargo, motion.residual_height) else SECOND
    return found


def height_note(scene: Scene) -> str:
    """Which heights are linear at full fidelity and why, in one line; empty where none is.

    "slosh height and residual height of soup: linear, since the flow is known in upright cylinders and boxes only", or
    "residual height: linear, since tolerance.tracking is a band of arms".
    """
    if scene.fidelity != "full":
        return ""
    orders, alone = height_orders(scene), scene.motion.residual_linear_since
    heights = SloshHeight.name if alone or scene.motion.stop else f"{SloshHeight.name} and {ResidualHeight.name}"
    titles = {cargo.name: cargo.title for cargo in scene.cargo}
    alike: dict[str, list[str]] = {}
    for name, order in orders.items():
        if order.startswith(_LINEAR):
            alike.setdefault(order, []).append(titles[name])
    notes = [f"{heights}{_of(names, len(orders))}: {order}" for order, names in alike.items()]
    if alone and orders and not scene.motion.stop:
        notes.append(f"{ResidualHeight.name}: {_LINEAR}{alone}")
    return "; ".join(notes)


def flow_note(scene: Scene) -> str:
    """Whose heights are judged by the nonlinear flow, where the scenario asks for it; empty elsewhere.

    "slosh height and residual height by the nonlinear flow: cup, mug; others to the second order".
    """
    rules = scene.motion
    asked = [(SloshHeight.name, rules.slosh_height)]
    asked += [] if rules.stop else [(ResidualHeight.name, rules.residual_height)]
    which = " and ".join(name for name, order in asked if order == "nonlinear")
    if scene.fidelity != "full" or not which:
        return ""
    found = [item for item in scene.cargo if by_nonlinear_flow(item, "nonlinear")]
    if not found:
        return f"{which}: of no liquid by the nonlinear flow, which is of upright cups and boxes that begin at rest"
    names = [item.title for item in found]
    known = [order for order in height_orders(scene).values() if not order.startswith(_LINEAR)]
    others = "; others to the second order" if len(found) < len(known) else ""
    if rules.speed_range is not None:
        others += "; at other speeds than planned to the second order"
    if any(offset.frequency for item in found for offset in liquid_offsets(item)):
        others += "; at other frequencies than stated to the second order"
    more = f" and {len(names) - _NAMED} more" if len(names) > _NAMED else ""
    return f"{which} by the nonlinear flow: {', '.join(names[:_NAMED])}{more}{others}"


def height_sentence(scene: Scene) -> str:
    """Both notes as sentences to be put behind others, with the space before each."""
    notes = (height_note(scene), flow_note(scene))
    return "".join(f" {note[:1].upper()}{note[1:]}." for note in notes if note)


def _of(names: list[str], count: int) -> str:
    if len(names) == count:
        return ""
    more = f" and {len(names) - _NAMED} more" if len(names) > _NAMED else ""
    return f" of {', '.join(names[:_NAMED])}{more}"
