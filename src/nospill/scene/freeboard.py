"""How high a liquid may swing: to the rim less a reserve where nothing is stated, and never until waves break."""

from __future__ import annotations

from dataclasses import replace
from functools import lru_cache

import numpy as np

from nospill.scene.cargo import Filling
from nospill.scene.containers.base import Container
from nospill.scene.containers.leaning import edge_of_plane
from nospill.scene.containers.vessel import Vessel
from nospill.scene.liquids import Liquid
from nospill.scene.scene import Fidelity
from nospill.scene.surface_tension.meniscus import meniscus_in
from nospill.scene.surface_tension.tension import ContactLine

_SAME = 2e-6
"""m; to which `edge_of_plane` is met."""


def default_slosh_height(
    container: Container,
    liquid: Liquid,
    level: float,
    *,
    reserve: float,
    contact_line: ContactLine = "",
    contact_angle: float | None = None,
) -> float:
    """Greatest crest, m, that leaves a reserve of the freeboard, upright and along the wall.

    In a vessel that opens, the edge of the liquid runs up the slope: the crest is then that of a plane surface whose
    edge leaves the reserve of the way along the wall from the surface at rest to the rim. Where a contact line is
    stated, what the meniscus at rest takes of the freeboard counts as filled.

    Args:
        container: of any shape.
        liquid: in it.
        level: of the flat surface at rest, m.
        reserve: fraction of the freeboard.
        contact_line: as for the modes.
        contact_angle: rad; None for the highest meniscus.

    Returns:
        m; negative where the meniscus takes all.
    """
    freeboard = container.height - level
    if contact_line:
        freeboard -= max(meniscus_in(container, liquid, level, contact_angle).rise, 0.0)
    if not isinstance(container, Vessel) or freeboard <= 0.0:
        return (1.0 - reserve) * freeboard
    return _on_a_slope(container, level, reserve, freeboard)


@lru_cache(maxsize=512)
def _on_a_slope(vessel: Vessel, level: float, reserve: float, freeboard: float) -> float:
    from scipy.optimize import brentq

    upright = (1.0 - reserve) * freeboard
    above = vessel.meridian.points
    above = np.vstack([(vessel.section(level).radius, level), above[above[:, 1] > level]])
    way = float(np.sum(np.linalg.norm(np.diff(above, axis=0), axis=1)))
    wanted = reserve * way + (vessel.height - level - freeboard)

    def spare(crest: float) -> float:
        return edge_of_plane(vessel, level, crest).along_wall - wanted

    if spare(upright) >= -_SAME:
        return upright
    return float(brentq(spare, 0.0, upright, xtol=_SAME / 10))  # type: ignore[arg-type]


def before_waves_break(filling: Filling, fidelity: Fidelity) -> Filling:
    """The liquid with at most the height up to which waves stay whole; as it is where closed, or as published.

    Args:
        filling: with the height that is stated or left by the rim.
        fidelity: of the scene.
    """
    if fidelity != "full" or filling.lid:
        return filling
    return replace(filling, max_slosh_height=min(filling.max_slosh_height, filling.breaking_height))
