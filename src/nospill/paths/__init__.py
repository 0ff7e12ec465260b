"""Paths of the tray: splines of position and yaw over s, waypoints, smoothing of recorded points."""
