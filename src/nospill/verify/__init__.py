"""Second opinions on a plan: its objects as rigid bodies on the moving tray in MuJoCo, its liquids by their flow.

Importing this package does not import MuJoCo; verifying objects does.
"""

from nospill.verify.report import ObjectReport as ObjectReport
from nospill.verify.report import Peak as Peak
from nospill.verify.report import Thresholds as Thresholds
from nospill.verify.report import VerifyReport as VerifyReport
from nospill.verify.tray_motion import PlayedJoints as PlayedJoints
from nospill.verify.verification import folder_joints as folder_joints
from nospill.verify.verification import verify as verify
from nospill.verify.verification import verify_folder as verify_folder
from nospill.verify.water import CupReport as CupReport
from nospill.verify.water import WaterReport as WaterReport
from nospill.verify.water import verify_water as verify_water
