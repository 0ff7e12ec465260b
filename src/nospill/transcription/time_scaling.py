"""The same motion, slower."""

from __future__ import annotations

from nospill.transcription.layout import Layout
from nospill.transcription.stages import Stages


def slowed(stages: Stages, layout: Layout, factor: float) -> Stages:
    """The same motion played `factor` times as slowly.

    Liquids follow in proportion to the tray's acceleration, which is nearly what they do and keeps them in phase; their
    equation of motion no longer holds to the last digit.
    """
    table = stages.table.copy()
    for chain in range(layout.chains):
        table[:, 3 * chain + 1] /= factor
        table[:, 3 * chain + 2] /= factor**2
    table[:, layout.jerks] /= factor**3
    table[:, layout.interval] *= factor
    table[:, layout.displacement] /= factor**2
    table[:, layout.velocity] /= factor**3
    for point in range(2):
        table[:, layout.acceleration(point)] /= factor**4
    for order in range(1, layout.orders + 1):
        table[:, layout.joint_derivative(order)] /= factor**order
    return Stages(stages.interval * factor, table, stages.self_motion)
