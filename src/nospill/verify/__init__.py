"""A second opinion on a plan: its objects as rigid bodies on the moving tray, in MuJoCo.

Importing this package does not import MuJoCo; verifying does.
"""

from nospill.verify.report import ObjectReport as ObjectReport
from nospill.verify.report import Peak as Peak
from nospill.verify.report import Thresholds as Thresholds
from nospill.verify.report import VerifyReport as VerifyReport
from nospill.verify.tray_motion import PlayedJoints as PlayedJoints
from nospill.verify.verification import folder_joints as folder_joints
from nospill.verify.verification import verify as verify
from nospill.verify.verification import verify_folder as verify_folder
