"""Potential flow of the liquid in an upright prism on a moving tray: to the first and second order, and in full."""

from nospill.potential_flow.basin import unsupported as unsupported
from nospill.potential_flow.crests import BodyRows as BodyRows
from nospill.potential_flow.crests import Crests as Crests
from nospill.potential_flow.crests import crests_along as crests_along
from nospill.potential_flow.integration import rows_at as rows_at
