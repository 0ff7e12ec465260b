"""Formulas as outlines, drawn by matplotlib's mathtext when the pages are built.

Nothing is fetched from a network when a page is read, and no font with mathematics is needed on the reader's machine.
What mathtext knows is what a page may use: no environments (matrices, aligned equations).
"""

from __future__ import annotations

import html
import re
from functools import cache

from docutils import nodes
from matplotlib import rc_context
from matplotlib.font_manager import FontProperties
from matplotlib.path import Path as Outline
from matplotlib.textpath import TextToPath
from sphinx.application import Sphinx
from sphinx.util import logging
from sphinx.writers.html5 import HTML5Translator

_LOG = logging.getLogger(__name__)
_SIZE = TextToPath.FONT_SCALE
"""Font size in which outlines come, whatever is asked for: all lengths below are in its units, hundredths of an em."""

_SCALE = {"inline": 1.05, "block": 1.12}
_MARGIN = 6.0
_LETTERS = {Outline.MOVETO: "M", Outline.LINETO: "L", Outline.CURVE3: "Q", Outline.CURVE4: "C", Outline.CLOSEPOLY: "Z"}


def add_formulas(app: Sphinx) -> None:
    """Register the renderer `outlines`."""
    app.add_html_math_renderer("outlines", (_inline, None), (_block, None))


@cache
def formula(tex: str, kind: str) -> str:
    """A formula as an SVG element in the colour and size of the text around it.

    Args:
        tex: without dollar signs.
        kind: "inline" or "block".

    Raises:
        ValueError: mathtext does not understand it.
    """
    # mathtext knows the long names of relations only, and puts no space before the names of functions.
    text = re.sub(r"\\(le|ge)\b", r"\\\1q", " ".join(tex.split()))
    text = re.sub(r"(?<=[\w}]) (?=\\(?:sin|cos|tan)h?\b)", r" \\, ", text)
    if kind == "block":
        text = text.replace(r"\frac", r"\dfrac")
    with rc_context({"mathtext.fontset": "stix"}):
        draw, font = TextToPath(), FontProperties(size=_SIZE)
        width, height, descent = draw.get_text_width_height_descent(f"${text}$", font, ismath=True)
        points, codes = draw.get_text_path(font, f"${text}$", ismath=True)
    outline = _outline(Outline(points, codes))
    em = _SCALE[kind] / _SIZE
    box = f"{-_MARGIN:g} {-(height - descent) - _MARGIN:.1f} {width + 2 * _MARGIN:.1f} {height + 2 * _MARGIN:.1f}"
    style = f"width:{(width + 2 * _MARGIN) * em:.3f}em;height:{(height + 2 * _MARGIN) * em:.3f}em"
    if kind == "inline":
        style += f";vertical-align:{-(descent + _MARGIN) * em:.3f}em;margin:0 {-_MARGIN * em:.3f}em"
    label = html.escape(text, quote=True)
    return (
        f'<svg class="formula" role="img" aria-label="{label}" viewBox="{box}" style="{style}" fill="currentColor">'
        f'<title>{label}</title><path d="{outline}"/></svg>'
    )


def _outline(path: Outline) -> str:
    """Path data with y downwards."""
    parts = []
    for points, code in path.iter_segments(curves=True, simplify=False):
        letter = _LETTERS[code]
        numbers = (
            ""
            if letter == "Z"
            else " ".join(f"{value * (1 if index % 2 == 0 else -1):.1f}" for index, value in enumerate(points))
        )
        parts.append(letter + numbers)
    return "".join(parts)


def _converted(node: nodes.Element, kind: str) -> str:
    try:
        return formula(node.astext(), kind)
    except ValueError as error:
        _LOG.warning("formula %r: %s", node.astext(), " ".join(str(error).split()), location=node)
        return html.escape(node.astext())


def _inline(self: HTML5Translator, node: nodes.math) -> None:
    self.body.append(self.starttag(node, "span", "", CLASS="math") + _converted(node, "inline") + "</span>")
    raise nodes.SkipNode


def _block(self: HTML5Translator, node: nodes.math_block) -> None:
    self.body.append(self.starttag(node, "div", CLASS="math") + _converted(node, "block") + "</div>\n")
    raise nodes.SkipNode
