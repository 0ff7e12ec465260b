"""Random tasks, planned and checked: the table of docs/reliability.md."""
