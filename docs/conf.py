"""Sphinx configuration of the documentation: `make docs`.

The pages are Markdown that any host shows; what can be read from the package stands in them
(`_ext/nospill_docs/blocks.py`). The build adds what takes plans, pictures, the gallery and executed notebooks
(`_ext/nospill_docs/extension.py`), and the Python reference in full. No step needs a network.
"""

from __future__ import annotations

import sys
from pathlib import Path

import nospill

sys.path.insert(0, str(Path(__file__).parent / "_ext"))

project = "nospill"
author = "nospill contributors"
copyright = author
version = release = nospill.__version__

extensions = ["myst_parser", "sphinx.ext.autodoc", "sphinx.ext.napoleon", "nospill_docs.extension"]
exclude_patterns = ["_build", "_generated", "_ext", "examples"]

myst_enable_extensions = ["dollarmath", "colon_fence", "deflist"]
myst_heading_anchors = 3

autodoc_member_order = "bysource"
autodoc_typehints = "signature"
autodoc_class_signature = "separated"
autodoc_preserve_defaults = True
napoleon_google_docstring = True
napoleon_numpy_docstring = False
napoleon_use_ivar = True
napoleon_custom_sections = ["Return value"]
add_module_names = False
python_use_unqualified_type_names = True

# Two primes are a second derivative, not a quotation mark.
smartquotes = False

nitpicky = True
nitpick_ignore_regex = [
    # Types of other libraries have no pages here, and their inventories would need a network.
    ("py:.*", r"(np|numpy|ca|casadi|os|pathlib|typing|collections|enum|abc)\..*"),
    ("py:.*", r"(Path|FilePath|Callable|Collection|Mapping|Sequence|Literal|Any|Protocol|PathLike)"),
    # Records that only the inside of the package hands around are named in signatures and have no entry.
    ("py:class", r"nospill\..*"),
    # The first names in "lower, upper: limits" are no types.
    ("py:class", r"[a-z_]+"),
]

html_math_renderer = "outlines"
html_theme = "furo"
html_title = f"nospill {release}"
html_static_path = ["_static"]
html_css_files = ["nospill.css"]
html_extra_path = ["_generated/extra"]
Path(__file__).parent.joinpath(*html_extra_path).mkdir(parents=True, exist_ok=True)
html_copy_source = False
html_show_sphinx = False
html_theme_options = {"sidebar_hide_name": False}
pygments_style = "friendly"
pygments_dark_style = "monokai"
