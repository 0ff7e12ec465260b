"""Tasks that cannot be done, and the reasons that are given: the table of docs/reasons.md."""
