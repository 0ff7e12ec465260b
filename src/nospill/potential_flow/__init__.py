"""Potential flow of the liquid in an upright prism on a moving tray: to the first and second order, and in full."""

from nospill.potential_flow.basin import COARSE as COARSE
from nospill.potential_flow.basin import driven_shapes as driven_shapes
from nospill.potential_flow.beyond_masses import beyond_masses as beyond_masses
from nospill.potential_flow.courses import BodyRows as BodyRows
from nospill.potential_flow.crests import Crests as Crests
from nospill.potential_flow.crests import SecondOrder as SecondOrder
from nospill.potential_flow.crests import crests_along as crests_along
from nospill.potential_flow.crests import doubt_of as doubt_of
from nospill.potential_flow.crests import largest_slopes as largest_slopes
from nospill.potential_flow.crests import second_order_along as second_order_along
from nospill.potential_flow.driven import Driven as Driven
from nospill.potential_flow.driven import driven as driven
from nospill.potential_flow.driven import height_gains as height_gains
from nospill.potential_flow.driven_along import STEP_ANGLE as STEP_ANGLE
from nospill.potential_flow.driven_along import second_order_states as second_order_states
from nospill.potential_flow.flow_along import flow_terms as flow_terms
from nospill.potential_flow.flow_along import flows_along as flows_along
from nospill.potential_flow.flow_along import of_masses as of_masses
from nospill.potential_flow.integration import rows_at as rows_at
from nospill.potential_flow.solving import greatest_height as greatest_height
