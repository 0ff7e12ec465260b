"""What a plan saves against what is usual: a level tray, and a trapezoid profile at constant limits."""

from nospill.comparison.compared import compared as compared
from nospill.comparison.trapezoid import trapezoid_motion as trapezoid_motion

__all__ = ["compared", "trapezoid_motion"]
