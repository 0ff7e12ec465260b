"""A certificate as a table, and the sentences below it: the same in a terminal and as text."""

from __future__ import annotations

from dataclasses import dataclass

from nospill.certification.height_order import flow_note, height_note
from nospill.certification.rims import rim_distances, rim_line
from nospill.certification.verdict import Certificate
from nospill.certification.wording import (
    full_model_note,
    integrity_line,
    linear_heights_line,
    row_text,
    verdict_line,
)
from nospill.core.short_names import short_names
from nospill.scene.scene import Scene

RIGHT = ("use", "value", "limit", "at")
"""Columns whose cells stand at their right end."""

_GAP = "  "


@dataclass(frozen=True, slots=True)
class CertificateTable:
    """Rows of a certificate as cells of text.

    Attributes:
        columns: their names.
        cells: row by row.
        failing: indices of the rows that do not hold.
    """

    columns: tuple[str, ...]
    cells: tuple[tuple[str, ...], ...]
    failing: frozenset[int]

    @property
    def text(self) -> str:
        """Its lines, each column as wide as its widest cell."""
        lines = [self.columns, *self.cells]
        widths = [max(len(line[index]) for line in lines) for index in range(len(self.columns))]
        aligned = [
            _GAP.join(
                cell.rjust(width) if name in RIGHT else cell.ljust(width)
                for name, cell, width in zip(self.columns, line, widths, strict=True)
            ).rstrip()
            for line in lines
        ]
        return "\n".join([aligned[0], "-" * max(map(len, aligned)), *aligned[1:]])


def certificate_table(certificate: Certificate, scene: Scene, *, everything: bool = False) -> CertificateTable:
    """The fullest row of each constraint, the fullest first, or all rows."""
    rows = certificate.rows if everything else certificate.listed_rows()
    joints = scene.robot.joints
    short = dict(zip(joints, short_names(joints), strict=True))
    failing = frozenset(index for index, row in enumerate(rows) if not row.ok)
    varied = any(row.variant for row in rows)
    cells = []
    for row in rows:
        text = row_text(row)
        mark = [] if not failing else ["" if row.ok else "FAILS"]
        own = [row.constraint, short.get(row.subject, row.subject), text.use, *mark, text.value, text.limit_and_unit]
        cells.append((*own, text.at_with_unit, *([row.variant] if varied else [])))
    columns = ["constraint", "of", "use", *(["FAILS"] if failing else []), "value", "limit", "at"]
    return CertificateTable((*columns, *(["with"] if varied else [])), tuple(cells), failing)


def certificate_notes(certificate: Certificate, scene: Scene, *, everything: bool = False) -> list[str]:
    """The sentences below the table: checks of the file, self-collision, rims, and what the full model sees."""
    rims = rim_line(rim_distances(scene, certificate.rows))
    heights, note = (
        (linear_heights_line(certificate.rows, scene.motion.slosh_height), height_note(scene), flow_note(scene)),
        full_model_note(certificate),
    )
    return [
        *([integrity_line(certificate)] if not everything and certificate.record_rows() else []),
        *([certificate.self_collision.text] if certificate.self_collision is not None else []),
        *([rims] if rims else []),
        *filter(None, heights),
        *([f"warning: {note}"] if note else []),
    ]


def certificate_text(certificate: Certificate, scene: Scene) -> str:
    """Verdict, table and sentences, as `nospill check` prints them."""
    table = certificate_table(certificate, scene)
    return "\n".join([verdict_line(certificate), "", table.text, *certificate_notes(certificate, scene)])
