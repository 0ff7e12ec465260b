"""The task as frozen records: tray, cargo, liquids, containers, tolerances."""
