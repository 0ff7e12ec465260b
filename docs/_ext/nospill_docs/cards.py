"""The cards of the home page: a picture, a question, and the page that answers it."""

from __future__ import annotations

import html
from dataclasses import dataclass

from nospill.scenario.examples import EXAMPLES
from nospill_docs.places import Places, copy_if_changed, write_if_changed


@dataclass(frozen=True, slots=True)
class Card:
    """One card.

    Attributes:
        page: its address from the home page.
        picture: a file in the generated pictures, or the moment of an example.
        title: a few words.
        text: one sentence.
    """

    page: str
    picture: str
    title: str
    text: str


CARDS = (
    Card("get-started.html", "moments.png", "Get started", "Two cups of your own in five minutes."),
    Card("gallery/index.html", "mixed-tray", "Gallery", "Every bundled example, with its motion to play."),
    Card("scenario-guide.html", "scenario.svg", "Scenario guide", "Robot, tray, objects, path: what to write."),
    Card("reading-a-certificate.html", "annotated-certificate.svg", "The certificate", "What each row proves."),
    Card(
        "physics/certificate.html#what-it-does-not-prove",
        "between-samples.svg",
        "Can I trust it?",
        "What it proves, and what not.",
    ),
    Card("physics/index.html", "forces-on-a-cup.svg", "Physics", "Every equation, from the tray to the water."),
    Card(
        "slosh-model.html",
        "measured-peaks.svg",
        "Against measurements",
        "Predicted and measured heights of 23 motions.",
    ),
    Card("exports.html", "coarse-samples.svg", "To the controller", "URScript, ROS 2, CSV, MAT, each read back."),
    Card("uncertainty.html", "corners.svg", "Numbers that are off", "Plans that hold for a range of numbers."),
    Card("robots.html", "robots.png", "Robots", "Seven arms, or any URDF of six or seven joints."),
    Card("performance.html", "planning-times.svg", "Performance", "Seconds, and tenths when planned again."),
    Card("conventions.html#where-to-look", "layers.svg", "The code", "Where each thing is, and why."),
)


def write_cards(places: Places) -> None:
    """Write the cards as one block, and their pictures beside the pages."""
    parts = []
    for card in CARDS:
        if card.picture in EXAMPLES:
            number = list(EXAMPLES).index(card.picture) + 1
            source = places.docs / "gallery" / f"{number:02d}-{card.picture}" / "moment.png"
        else:
            source = places.generated / "pictures" / card.picture
        name = f"{source.stem if card.picture not in EXAMPLES else card.picture}{source.suffix}"
        copy_if_changed(source, places.generated / "extra" / "cards" / name)
        parts.append(
            f'<a class="card" href="{card.page}"><img src="cards/{name}" alt="" loading="lazy">'
            f"<b>{html.escape(card.title)}</b><span>{html.escape(card.text)}</span></a>"
        )
    block = "\n".join(parts)
    write_if_changed(places.generated / "cards.md", f'```{{raw}} html\n<div class="cards">\n{block}\n</div>\n```\n')
