"""What the studio adds to viser's page: keys, names and defaults of fields, and how it fits a narrow window.

viser's text fields have neither placeholders nor a name that a screen reader can tell, and its client has no keys for
undo. One script, started once in every tab, watches the page and adds them; `field_note` carries what it needs below
each field.
"""

from __future__ import annotations

from collections.abc import Sequence
from html import escape

from nospill.viewer.phone import PAGE, PHONE_STYLE

WRONG = "#9A4300"
"""Colour of what has to be corrected."""


def page_setup() -> str:
    """The style and the script, as HTML for an element of the page that never changes."""
    started = f"<img alt='' src='data:,' hidden onerror='{_SCRIPT}'>"
    return f"<div id='{PAGE}'><style>{_STYLE}{PHONE_STYLE}</style>{started}</div>"


def field_note(sentences: Sequence[str], default: str) -> str:
    """What stands below a field: its faults, and unseen the default that it shows while it is empty."""
    lines = "<br>".join(escape(sentence) for sentence in sentences)
    fault = (
        f"<div class='nospill-fault' role='alert' style='margin:-2px 10px 8px 10px;padding:2px 6px;border-left:3px "
        f"solid {WRONG};background:#fdf1e7;color:{WRONG};font-size:12px;line-height:1.35;"
        f"overflow-wrap:anywhere'>{lines}</div>"
        if sentences
        else ""
    )
    shown = escape(default, quote=True)
    return f"<div class='nospill-field' data-default='{shown}' data-wrong='{int(bool(sentences))}'>{fault}</div>"


_STYLE = (
    f"[data-nospill-wrong='1']{{border:2px solid {WRONG}!important}}"
    "input::placeholder,textarea::placeholder{color:#8a8a8a!important;opacity:1}"
    "[data-object]:focus{outline:none}"
    "[data-object]:focus>:first-child{stroke:#111;stroke-width:3;stroke-dasharray:5 3}"
    ".mantine-Tabs-root{margin-top:6px}"
    ".mantine-ScrollArea-content{padding-right:6px;box-sizing:border-box}"
    # Plan, Stop and the headline below them stay in sight while the fields are scrolled.
    ".mantine-ScrollArea-content [style*='overflow: hidden']:has(#nospill-page){overflow:clip!important}"
    "div:has(+div>#nospill-headline),div:has(>#nospill-headline){position:sticky;z-index:6;background:#fff}"
    "div:has(+div>#nospill-headline){top:0;padding-top:4px;box-shadow:-10px 0 #fff,10px 0 #fff}"
    "div:has(>#nospill-headline){top:33px;padding-bottom:4px}"
    ".mantine-ScrollArea-viewport{scroll-padding-top:110px}"
)

_SCRIPT = escape(
    """
(function () {
  if (window.nospillPage) return;
  window.nospillPage = true;
  var focused = null, known = null;
  function set(node, name, value) { if (node.getAttribute(name) !== value) node.setAttribute(name, value); }
  function look() {
    document.querySelectorAll('label[for]').forEach(function (label) {
      var row = label.closest('.mantine-Flex-root');
      var entry = row && row.querySelector('input:not([type=hidden]),textarea');
      if (entry) set(entry, 'aria-label', label.textContent);
    });
    document.querySelectorAll('.nospill-field').forEach(function (note) {
      var row = note.parentElement.previousElementSibling;
      var entry = row && row.querySelector('input:not([type=hidden]),textarea');
      if (!entry) return;
      set(entry, 'placeholder', note.dataset.default);
      set(entry, 'data-nospill-wrong', note.dataset.wrong);
      set(entry, 'aria-invalid', note.dataset.wrong === '1' ? 'true' : 'false');
    });
    var again = focused && document.activeElement === document.body && document.getElementById(focused);
    if (again) again.focus({preventScroll: true});
  }
  new MutationObserver(look).observe(document.body, {childList: true, subtree: true});
  look();
  window.nospillSay = function (object, x, y, end) {
    var field = document.getElementById('nospill-plan').parentElement.nextElementSibling.querySelector('input');
    window.nospillReports = (window.nospillReports || 0) + 1;
    var text = JSON.stringify({object: object, x: x, y: y, end: end, count: window.nospillReports});
    Object.getOwnPropertyDescriptor(HTMLInputElement.prototype, 'value').set.call(field, text);
    field.dispatchEvent(new Event('input', {bubbles: true}));
  };
  function object_of(node) { return node && node.closest ? node.closest('[data-object]') : null; }
  document.addEventListener('focusin', function (event) {
    var node = object_of(event.target);
    focused = node ? node.id : null;
  });
  document.addEventListener('pointerdown', function (event) { if (!object_of(event.target)) focused = null; }, true);
  var ways = {ArrowLeft: [-1, 0], ArrowRight: [1, 0], ArrowDown: [0, -1], ArrowUp: [0, 1]};
  function press(name) {
    document.querySelectorAll('button').forEach(function (button) {
      if (button.textContent === name) button.click();
    });
  }
  function move(node, way) {
    var picture = document.getElementById('nospill-tray'), grid = +picture.dataset.grid, step = grid || 1;
    var stale = known && known.id === node.id && +picture.dataset.count < window.nospillReports;
    var from = stale ? known.at : [+node.dataset.x, +node.dataset.y];
    var at = from.map(function (x, axis) {
      if (!way[axis]) return x;
      return grid ? Math.round(x / grid) * grid + way[axis] * step : x + way[axis] * step;
    });
    known = {id: node.id, at: at};
    window.nospillSay(+node.dataset.object, at[0], at[1], false);
  }
  function handled(event) {
    var key = event.key.toLowerCase(), node = object_of(document.activeElement);
    if ((event.ctrlKey || event.metaKey) && !event.altKey) {
      if (key === 'z' && !event.shiftKey) { press('Undo'); return true; }
      if (key === 'z' || key === 'y') { press('Redo'); return true; }
      return false;
    }
    if (!node || event.altKey) return false;
    if (ways[event.key]) { move(node, ways[event.key]); return true; }
    if (event.key === 'Enter' || event.key === ' ') {
      window.nospillSay(+node.dataset.object, null, null, true);
      return true;
    }
    return false;
  }
  window.addEventListener('keydown', function (event) {
    if (!handled(event)) return;
    event.preventDefault();
    event.stopImmediatePropagation();
  }, true);
})()
""",
    quote=True,
)
"""The observer is called before the next key is, so that no field is ever without its name. React listens for the event
`input` after a value was set behind its back. The tray's picture comes anew while keys are pressed: it says up to which
report it is true, and an object that had the focus gets it again."""
