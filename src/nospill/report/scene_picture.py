"""The motion as it looks, for a report: the whole arm, and the tray from near, at one moment."""

from __future__ import annotations

import io

import numpy as np
from PIL import Image

from nospill.drawing.props import SceneBuilder
from nospill.drawing.timeline import make_film
from nospill.drawing.views import CLOSE, View, camera_frame, viewpoint
from nospill.film.picture import draw
from nospill.plots.evidence import Evidence

MOMENT = 0.35
"""Part of the motion's time: mostly on the way, and seldom level."""
_SIZE, _RATE, _QUALITY = (760, 500), 50.0, 82


def scene_picture(evidence: Evidence) -> bytes:
    """Both views side by side as JPEG.

    Raises:
        ScenarioError: the robot's URDF cannot be read.
    """
    film = make_film(evidence.plan, evidence.judgement, rate=_RATE)
    index, views = film.index(MOMENT * film.end_time), []
    for view in (View.ARM, View.TRAY):
        hand = SceneBuilder(film, path=view not in CLOSE)
        camera = viewpoint([film], view, aspect=_SIZE[0] / _SIZE[1])
        views.append(draw(hand, index, camera, camera_frame(film, view), size=_SIZE))
    file = io.BytesIO()
    Image.fromarray(np.hstack(views)).save(file, format="JPEG", quality=_QUALITY)
    return file.getvalue()
