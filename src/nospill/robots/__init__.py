"""Arms: the record of one, the catalogue, forward kinematics, inverse kinematics and joint paths along a tray path."""
