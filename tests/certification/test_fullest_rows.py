"""Which row of a constraint is shown."""

from __future__ import annotations

from nospill.certification.verdict import Certificate, Row


def test_of_objects_that_use_as_much_the_first_is_named_however_sums_are_rounded() -> None:
    def row(subject: str, use: float, constraint: str = "twist") -> Row:
        return Row(constraint, subject, "", 1.0, use, 1.0 - use, 0.0, True, "")

    rows = (row("tea", 1e-17), row("espresso", 3e-16), row("tea", 0.5, "slip"), row("espresso", 0.5 + 1e-8, "slip"))
    certificate = Certificate(True, 2000.0, rows)
    assert [(one.constraint, one.subject) for one in certificate.worst_rows()] == [
        ("slip", "espresso"),
        ("twist", "tea"),
    ]
