"""A page to share and a film of a plan."""

from pathlib import Path

import nospill as ns
from nospill.drawing.timeline import load_films
from nospill.drawing.views import View
from nospill.film.writing import Format, save_film
from nospill.report import make_report, save_report

plan = ns.plan("pp-two-cups")
folder = Path("out/two-cups")
plan.save(folder)

size = save_report(make_report(plan), "two-cups.html")
print(f"two-cups.html: {size / 1e6:.1f} MB, one file with figures and certificate")

form = Format(View.TRAY, speed=0.5, size=(480, 270), rate=10)
films = load_films([folder], rate=form.motion_rate, after_end=0.4)
count = save_film(films, Path("two-cups.webp"), form)
print(f"two-cups.webp: {count} pictures")
plan.plot("summary").savefig("report_and_film.png", dpi=60)
