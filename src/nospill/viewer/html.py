"""A motion as one file: viser's client, the recorded scene and the charts, to be opened from a disk or a mail."""

from __future__ import annotations

from collections.abc import Sequence
from html import escape
from pathlib import Path

from nospill.core.files import atomic_text
from nospill.drawing.timeline import Film
from nospill.drawing.views import View
from nospill.viewer.charts import Charts, colour_key
from nospill.viewer.live import running_server, show_plans
from nospill.viewer.meshes import Visuals
from nospill.viewer.playback import SPEEDS, START_SPEED
from nospill.viewer.words import INTRODUCTION, STYLE, introduction, title_of

HTML_RATE = 30.0
"""Pictures per second of the file."""
LARGEST_FILE = 5_000_000
"""Bytes a file should not exceed; only meshes with many triangles do."""

_SIDE = 350
"""px; width of the column with the charts."""


def save_html(
    films: Sequence[Film], path: str | Path, *, visuals: Visuals | None = None, view: View = View.TRAY
) -> int:
    """Write plans, side by side on one clock, as one HTML file that needs no network.

    Args:
        films: cut at the rate the file is to have, all of one length.
        path: of the file; an earlier one is replaced.
        visuals: meshes of the arm.
        view: where everything is seen from; the file has that one alone.

    Returns:
        Size of the file, bytes.

    Raises:
        MissingExtraError: viser is not installed.
        ScenarioError: a robot's URDF cannot be read.
        PlanFolderError: the file cannot be written.
    """
    with running_server(port=0) as server:
        shown = show_plans(server, films, visuals=visuals, view=view)
        recording = server.get_scene_serializer()
        longest = max(films, key=lambda film: film.length)
        for t in longest.t[1:]:
            recording.insert_sleep(1.0 / longest.rate)
            for item in shown.views:
                item.show(float(t))
        page = recording.as_html()
    text = with_charts(page, films, shown.charts)
    atomic_text(path, text)
    return len(text.encode())


def with_charts(page: str, films: Sequence[Film], charts: Charts) -> str:
    """The page of viser with a column beside the scene: words, charts, a cursor that follows its player's slider."""
    titles = [title_of(film) for film in films]
    head = f"<style>{_STYLE}{STYLE}</style><script>{CLOCK}</script></head>"
    side = (
        f"<aside id='nospill-side'><div class='{INTRODUCTION}'>{introduction(films)}</div>"
        f"<p>Drag to turn, wheel to zoom, space bar to play or pause. {_speeds()}</p>"
        f"{colour_key()}{charts.page}</aside><script>{_script(charts)}</script></body>"
    )
    page = page.replace("<title>Viser</title>", f"<title>{escape(' | '.join(titles))}</title>", 1)
    page = page.replace('content="Viser client"', f'content="{escape(titles[0])}"', 1)
    before, _, after = page.rpartition("</head>")
    page = f"{before}{head}{after}"
    before, _, after = page.rpartition("</body>")
    return f"{before}{side}{after}"


def _speeds() -> str:
    """The choice of speeds, the same as live."""
    options = "".join(
        f"<option value='{value}'{' selected' if label == START_SPEED else ''}>{label}</option>"
        for label, value in SPEEDS.items()
    )
    return f"<label>Speed <select id='nospill-speed'>{options}</select></label>"


CLOCK = (
    # viser's player measures time by Date.now and has no speed below a half: a clock that runs at the speed chosen.
    f"(function(){{var now=Date.now,speed={SPEEDS[START_SPEED]},real=now(),shown=real;"
    "Date.now=function(){return shown+(now()-real)*speed};"
    "document.addEventListener('change',function(event){if(event.target.id==='nospill-speed'){"
    "shown=Date.now();real=now();speed=+event.target.value;event.target.blur()}});})();"
)
"""Script for the head of the file."""
_STYLE = (
    "#root .mantine-Select-root{display:none}.mantine-Notifications-root{display:none}"
    f"#root{{width:calc(100% - {_SIDE}px)!important}}"
    f"#nospill-side{{position:fixed;top:0;right:0;bottom:0;width:{_SIDE}px;box-sizing:border-box;padding:10px 12px;"
    "overflow-y:auto;background:#fff;border-left:1px solid #ddd;font-family:system-ui,sans-serif;color:#222}"
    "#nospill-side>p{font-size:11px;color:#555;margin:0 0 8px}"
    "@media(max-width:760px){#root{width:100%!important;height:50%!important}"
    "#nospill-side{top:50%;left:0;width:100%;border-left:0;border-top:1px solid #ddd}}"
)


def _script(charts: Charts) -> str:
    """Reads the time from the player's slider, which carries it for screen readers, and moves the cursor."""
    first, last = charts.cursor_at(0.0), charts.cursor_at(charts.length)
    return (
        "(function(){var style=document.documentElement.style,shown=null;"
        "function follow(){var slider=document.querySelector('#root [role=slider]');"
        "var t=slider?parseFloat(slider.getAttribute('aria-valuenow')):NaN;"
        f"if(isFinite(t)&&t!==shown){{shown=t;var part=Math.min(1,Math.max(0,t/{charts.length!r}));"
        f"var x={first!r}+({last - first!r})*part;"
        "style.setProperty('--nospill-x',x.toFixed(2)+'%');"
        "style.setProperty('--nospill-t',\"'\"+t.toFixed(2)+\" s'\");"
        "style.setProperty('--nospill-shift',x<75?'4px':'calc(-100% - 4px)');}"
        "}setInterval(follow,40);})();"
    )
