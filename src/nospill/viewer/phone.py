"""How viser's page fits a window as narrow as a phone's."""

from __future__ import annotations

PAGE = "nospill-page"
"""Id of an element that stands in the controls and marks them for the style."""

_SHEET = 62
"""Share of the window that the controls take there, percent; the scene has the rest."""

# viser's own sheet is narrower than the window and lies over the scene, which goes on behind it.
PHONE_STYLE = (
    "@media(max-width:36em){"
    f".mantine-Paper-root:has(#{PAGE}){{width:100%!important;max-height:{_SHEET}%!important}}"
    f".mantine-Paper-root:has(#{PAGE}) .mantine-ScrollArea-content>div{{width:100%!important}}"
    f"#root:has([aria-hidden=false] #{PAGE}) div:has(>canvas){{bottom:{_SHEET}%!important}}"
    "}"
)
"""Style sheet: a sheet as wide as the window, and the scene above it."""
