"""What the user states: links, members, sections, materials, joints, drive, analysis."""

from fenics_mech.scene.analysis_options import Analysis, PoincareSection
from fenics_mech.scene.applied_loads import (
    FactorExpression,
    FactorHarmonics,
    FactorTable,
    Impulse,
    LineLoad,
    Load,
    Pulse,
)
from fenics_mech.scene.bodies import Ground, Link, Material, Member, Mesh, PointMass, RigidBody, StressLife
from fenics_mech.scene.damping_options import AirDrag, Damping
from fenics_mech.scene.design import Design, Notch, Pin
from fenics_mech.scene.drives import Drive, Expression, Harmonics, Motor, Table
from fenics_mech.scene.factories import four_bar, manipulator, quick_return, slider_crank
from fenics_mech.scene.files import load, parse, schema
from fenics_mech.scene.freedoms import DirectCurrentMotor, FormulaEffort, Freedom, InductionMotor, SpeedController
from fenics_mech.scene.importing import from_drawing, from_pylinkage
from fenics_mech.scene.in_space import (
    Misalignment,
    PointDamper,
    SpatialAnalysis,
    SpatialBody,
    SpatialCustomSection,
    SpatialDamping,
    SpatialForce,
    SpatialGround,
    SpatialJoint,
    SpatialLink,
    SpatialMass,
    SpatialMember,
    SpatialMesh,
    SpatialPolygonSection,
    SpatialScene,
    SpatialTorque,
)
from fenics_mech.scene.joint_laws import (
    Bushing,
    Clearance,
    Contact,
    Friction,
    GuideClearance,
    JointEffort,
    SideContact,
    Stop,
)
from fenics_mech.scene.joints import Prismatic, Revolute, Slot, Weld
from fenics_mech.scene.load_case import LoadCase
from fenics_mech.scene.load_cases import in_case
from fenics_mech.scene.meshing import refined
from fenics_mech.scene.models import Scene
from fenics_mech.scene.observations import Measurement, TracedPoint
from fenics_mech.scene.paired_joints import Cam, GearPair
from fenics_mech.scene.plugged import add_kinds
from fenics_mech.scene.rest_to_rest import RestToRest
from fenics_mech.scene.run_ups import TimeExpression, TimeTable
from fenics_mech.scene.sections import (
    CustomSection,
    ISection,
    LaminateSection,
    Ply,
    PolygonPart,
    PolygonSection,
    RectangleSection,
    RoundSection,
    Section,
    TaperSection,
    TubeSection,
    VariableSection,
)
from fenics_mech.scene.springs_dampers import HingeDamper, HingeSpring, LineDamper, LineSpring
from fenics_mech.scene.state_factors import FactorFormula, FactorTimes
from fenics_mech.scene.study import Limit, Scatter, Study, Target, Tied, Variable
from fenics_mech.scene.synthesis_tasks import FunctionTask, MotionTask, PathTask, Pose, load_task
from fenics_mech.scene.tolerance import stated as stated_tolerance
from fenics_mech.scene.writing import write_scene

__all__ = [
    "AirDrag",
    "Analysis",
    "Bushing",
    "Cam",
    "Clearance",
    "Contact",
    "CustomSection",
    "Damping",
    "Design",
    "DirectCurrentMotor",
    "Drive",
    "Expression",
    "FactorExpression",
    "FactorFormula",
    "FactorHarmonics",
    "FactorTable",
    "FactorTimes",
    "FormulaEffort",
    "Freedom",
    "Friction",
    "FunctionTask",
    "GearPair",
    "Ground",
    "GuideClearance",
    "Harmonics",
    "HingeDamper",
    "HingeSpring",
    "ISection",
    "Impulse",
    "InductionMotor",
    "JointEffort",
    "LaminateSection",
    "Limit",
    "LineDamper",
    "LineLoad",
    "LineSpring",
    "Link",
    "Load",
    "LoadCase",
    "Material",
    "Measurement",
    "Member",
    "Mesh",
    "Misalignment",
    "MotionTask",
    "Motor",
    "Notch",
    "PathTask",
    "Pin",
    "Ply",
    "PoincareSection",
    "PointDamper",
    "PointMass",
    "PolygonPart",
    "PolygonSection",
    "Pose",
    "Prismatic",
    "Pulse",
    "RectangleSection",
    "RestToRest",
    "Revolute",
    "RigidBody",
    "RoundSection",
    "Scatter",
    "Scene",
    "Section",
    "SideContact",
    "Slot",
    "SpatialAnalysis",
    "SpatialBody",
    "SpatialCustomSection",
    "SpatialDamping",
    "SpatialForce",
    "SpatialGround",
    "SpatialJoint",
    "SpatialLink",
    "SpatialMass",
    "SpatialMember",
    "SpatialMesh",
    "SpatialPolygonSection",
    "SpatialScene",
    "SpatialTorque",
    "SpeedController",
    "Stop",
    "StressLife",
    "Study",
    "Table",
    "TaperSection",
    "Target",
    "Tied",
    "TimeExpression",
    "TimeTable",
    "TracedPoint",
    "TubeSection",
    "Variable",
    "VariableSection",
    "Weld",
    "four_bar",
    "from_drawing",
    "from_pylinkage",
    "in_case",
    "load",
    "load_task",
    "manipulator",
    "parse",
    "quick_return",
    "refined",
    "schema",
    "slider_crank",
    "stated_tolerance",
    "write_scene",
]

add_kinds(Scene)  # those of other packages, which import this room
