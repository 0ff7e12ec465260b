"""What is left of a plan when friction, fill, damping, place and mass are not what the scenario says."""

from nospill.margins.ranges import FACTORS as FACTORS
from nospill.margins.ranges import Ranges as Ranges
from nospill.margins.ranges import scenario_ranges as scenario_ranges
from nospill.margins.report import Influence as Influence
from nospill.margins.report import MarginsReport as MarginsReport
from nospill.margins.report import Probability as Probability
from nospill.margins.report import probability as probability
from nospill.margins.study import margins as margins
