"""Where objects, tray and arm had best stand: the shortest certified motion over ranges of a scenario's keys."""
