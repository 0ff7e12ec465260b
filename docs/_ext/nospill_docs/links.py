"""After the build: every link inside the site leads to a file and, where it names one, to an anchor in it."""

from __future__ import annotations

from html.parser import HTMLParser
from pathlib import Path
from urllib.parse import unquote, urlsplit

from sphinx.application import Sphinx
from sphinx.util import logging

_LOG = logging.getLogger(__name__)


class _Page(HTMLParser):
    """Collects the links and the anchors of one page."""

    def __init__(self) -> None:
        super().__init__()
        self.links: list[str] = []
        self.anchors: set[str] = set()

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        for key, value in attrs:
            if key == "id" and value:
                self.anchors.add(value)
            elif key in ("href", "src") and value:
                self.links.append(value)


def broken_links(site: Path) -> list[tuple[str, str]]:
    """Pages of a built site and the links in them that lead nowhere; links to other hosts are not followed."""
    # Scenes of the viewer are programs, not pages: what they load lies inside them.
    pages = {path: _read(path) for path in sorted(site.rglob("*.html")) if "scenes" not in path.relative_to(site).parts}
    broken = []
    for path, page in pages.items():
        for link in page.links:
            parts = urlsplit(link)
            if parts.scheme or parts.netloc:
                continue
            target = (path.parent / unquote(parts.path)).resolve() if parts.path else path
            if target.is_dir():
                target /= "index.html"
            anchor = unquote(parts.fragment)
            known = pages.get(target)
            if not target.is_file() or (anchor and known is not None and anchor not in known.anchors):
                broken.append((str(path.relative_to(site)), link))
    return broken


def check_links(app: Sphinx, failure: Exception | None) -> None:
    """Warn (an error with -W) of every link that leads nowhere."""
    if failure is None and app.builder.format == "html":
        for page, link in broken_links(Path(app.outdir).resolve()):
            _LOG.warning("%s: the link %s leads nowhere", page, link)


def _read(path: Path) -> _Page:
    page = _Page()
    page.feed(path.read_text(encoding="utf-8"))
    return page
