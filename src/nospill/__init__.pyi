# What `import nospill as ns` offers: the only list of it. `__init__.py` reads the names here and imports each at its
# first use, so that reading a scenario needs no optimiser (as SPEC 1 of scientific Python has it).

from nospill.certification.certificate import certify as certify
from nospill.certification.certificate import certify_joints as certify_joints
from nospill.certification.histories import ContactLoad as ContactLoad
from nospill.certification.histories import History as History
from nospill.certification.histories import ModalStates as ModalStates
from nospill.certification.verdict import Certificate as Certificate
from nospill.errors import Change as Change
from nospill.errors import ClusterError as ClusterError
from nospill.errors import MissingExtraError as MissingExtraError
from nospill.errors import ModelError as ModelError
from nospill.errors import NoSolutionError as NoSolutionError
from nospill.errors import NospillError as NospillError
from nospill.errors import PlanFolderError as PlanFolderError
from nospill.errors import ScenarioError as ScenarioError
from nospill.laws.constraints.base import Cone as Cone
from nospill.laws.constraints.base import Constraint as Constraint
from nospill.laws.constraints.base import EvaluationPoint as EvaluationPoint
from nospill.laws.constraints.base import Range as Range
from nospill.laws.constraints.base import Role as Role
from nospill.laws.sample import Sample as Sample
from nospill.layouts.record import Layout as Layout
from nospill.layouts.search import layout as layout
from nospill.motion.trajectory import Trajectory as Trajectory
from nospill.motion_files.judging import JudgedMotion as JudgedMotion
from nospill.motion_files.judging import judge as judge
from nospill.planning.cycles import plan_cycle as plan_cycle
from nospill.planning.planner import Planner as Planner
from nospill.planning.planner import plan as plan
from nospill.planning.retiming import retime as retime
from nospill.plans.cycle import CycleCertificate as CycleCertificate
from nospill.plans.cycle import CyclePlan as CyclePlan
from nospill.plans.cycle_folder import load_cycle_plan as load_cycle_plan
from nospill.plans.cycle_judge import judge_cycle as judge_cycle
from nospill.plans.handover import hand_over as hand_over
from nospill.plans.loading import load_plan as load_plan
from nospill.plans.plan import Plan as Plan
from nospill.plans.rows import with_residual_slosh as with_residual_slosh
from nospill.plans.state import MotionState as MotionState
from nospill.scenario import approach_entry as _approach
from nospill.scenario import arrays as _arrays
from nospill.scenario import capsule_entry as _capsules
from nospill.scenario import cargo_entries as _cargo
from nospill.scenario import controller_entry as _controller
from nospill.scenario import free_path_entry as _free
from nospill.scenario import initial_state_entry as _initial
from nospill.scenario import leg_entry as _legs
from nospill.scenario import model as _model
from nospill.scenario import place_entry as _places
from nospill.scenario import robot_entry as _robot
from nospill.scenario import swing_entry as _swing
from nospill.scenario import tolerance_entry as _tolerance
from nospill.scenario import tracking_entry as _tracking
from nospill.scenario.cycles import load_cycle as load_cycle
from nospill.scenario.free_path_entry import FreePath as FreePath
from nospill.scenario.joints_path_entry import JointsPath as JointsPath
from nospill.scenario.loading import load as load
from nospill.scenario.model import Scenario as Scenario
from nospill.scenario.obstacle_entries import BoxObstacle as BoxObstacle
from nospill.scenario.obstacle_entries import CapsuleObstacle as CapsuleObstacle
from nospill.scenario.obstacle_entries import CylinderObstacle as CylinderObstacle
from nospill.scenario.obstacle_entries import HalfspaceObstacle as HalfspaceObstacle
from nospill.scenario.obstacle_entries import MeshObstacle as MeshObstacle
from nospill.scenario.obstacle_entries import SphereObstacle as SphereObstacle
from nospill.scenario.path_entries import ArcPath as ArcPath
from nospill.scenario.path_entries import BsplinePath as BsplinePath
from nospill.scenario.path_entries import LinePath as LinePath
from nospill.scenario.path_entries import PresetPath as PresetPath
from nospill.scenario.path_entries import WaypointsPath as WaypointsPath
from nospill.scene.cycle import Cycle as Cycle
from nospill.scene.scene import Scene as Scene
from nospill.simulation.simulate import simulate_slosh as simulate_slosh
from nospill.stopping.recovery import recover as recover
from nospill.stopping.stoppable import plan_stoppable as plan_stoppable
from nospill.stopping.stops import stops as stops
from nospill.sweeps.bounds import Bound as Bound
from nospill.sweeps.bounds import largest as largest
from nospill.sweeps.record import Sweep as Sweep
from nospill.sweeps.sweeping import sweep as sweep

# the tables of a scenario, as classes to fill
Approach = _approach.ApproachTable
CargoArray = _arrays.CargoArrayTable
LinkCapsule = _capsules.LinkCapsuleTable
Bowl = _cargo.BowlTable
Box = _cargo.BoxTable
ConicalFlask = _cargo.ConicalFlaskTable
Cylinder = _cargo.CylinderTable
Liquid = _cargo.LiquidTable
Profile = _cargo.ProfileTable
RoundFlask = _cargo.RoundFlaskTable
InitialState = _initial.InitialStateTable
Swing = _swing.SwingTable
VariantSwing = _swing.VariantSwingTable
Tapered = _cargo.TaperedTable
TestTube = _cargo.TestTubeTable
WineGlass = _cargo.WineGlassTable
Controller = _controller.ControllerTable
Leg = _legs.LegTable
Region = _free.RegionTable
Via = _free.ViaTable
Motion = _model.MotionTable
Output = _model.OutputTable
Planning = _model.PlanningTable
Tray = _model.TrayTable
Place = _places.PlaceTable
JointLimits = _robot.JointLimitsTable
Robot = _robot.RobotTable
CargoTolerance = _tolerance.CargoToleranceTable
Tolerance = _tracking.ToleranceTable
Tracking = _tracking.TrackingTable

__version__: str
