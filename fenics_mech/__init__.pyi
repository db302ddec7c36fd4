"""The names at the top level and their modules: type checkers read them here, and `__init__.py` imports by them."""

# ruff: noqa: I001

from fenics_mech._version import __version__ as __version__
from fenics_mech.analysis import analyse as analyse
from fenics_mech.errors import (
    AssemblyError as AssemblyError,
    MechanismError as MechanismError,
    ResultError as ResultError,
    SceneError as SceneError,
    SolverError as SolverError,
    TooLargeError as TooLargeError,
    UnresolvedError as UnresolvedError,
    ViewError as ViewError,
)
from fenics_mech.recovery import Result as Result
from fenics_mech.recovery.sound import sound as sound
from fenics_mech.recovery.spatial_result import SpatialResult as SpatialResult
from fenics_mech.recovery.stress_figures import fatigue as fatigue
from fenics_mech.safety import Verdict as Verdict, judge as judge
from fenics_mech.safety.load_cases import envelope as envelope
from fenics_mech.scene import (
    AirDrag as AirDrag,
    Analysis as Analysis,
    Bushing as Bushing,
    Cam as Cam,
    Clearance as Clearance,
    Contact as Contact,
    CustomSection as CustomSection,
    Damping as Damping,
    Design as Design,
    DirectCurrentMotor as DirectCurrentMotor,
    Drive as Drive,
    Expression as Expression,
    FactorExpression as FactorExpression,
    FactorFormula as FactorFormula,
    FactorHarmonics as FactorHarmonics,
    FactorTable as FactorTable,
    FactorTimes as FactorTimes,
    FormulaEffort as FormulaEffort,
    Freedom as Freedom,
    Friction as Friction,
    FunctionTask as FunctionTask,
    GearPair as GearPair,
    Ground as Ground,
    GuideClearance as GuideClearance,
    Harmonics as Harmonics,
    HingeDamper as HingeDamper,
    HingeSpring as HingeSpring,
    ISection as ISection,
    Impulse as Impulse,
    InductionMotor as InductionMotor,
    JointEffort as JointEffort,
    LaminateSection as LaminateSection,
    Limit as Limit,
    LineDamper as LineDamper,
    LineLoad as LineLoad,
    LineSpring as LineSpring,
    Link as Link,
    Load as Load,
    LoadCase as LoadCase,
    Material as Material,
    Measurement as Measurement,
    Member as Member,
    Mesh as Mesh,
    Misalignment as Misalignment,
    MotionTask as MotionTask,
    Motor as Motor,
    Notch as Notch,
    PathTask as PathTask,
    Pin as Pin,
    Ply as Ply,
    PoincareSection as PoincareSection,
    PointDamper as PointDamper,
    PointMass as PointMass,
    PolygonPart as PolygonPart,
    PolygonSection as PolygonSection,
    Pose as Pose,
    Prismatic as Prismatic,
    Pulse as Pulse,
    RectangleSection as RectangleSection,
    RestToRest as RestToRest,
    Revolute as Revolute,
    RigidBody as RigidBody,
    RoundSection as RoundSection,
    Scatter as Scatter,
    Scene as Scene,
    SideContact as SideContact,
    Slot as Slot,
    SpatialAnalysis as SpatialAnalysis,
    SpatialBody as SpatialBody,
    SpatialCustomSection as SpatialCustomSection,
    SpatialDamping as SpatialDamping,
    SpatialForce as SpatialForce,
    SpatialGround as SpatialGround,
    SpatialJoint as SpatialJoint,
    SpatialLink as SpatialLink,
    SpatialMass as SpatialMass,
    SpatialMember as SpatialMember,
    SpatialMesh as SpatialMesh,
    SpatialPolygonSection as SpatialPolygonSection,
    SpatialScene as SpatialScene,
    SpatialTorque as SpatialTorque,
    SpeedController as SpeedController,
    Stop as Stop,
    StressLife as StressLife,
    Study as Study,
    Table as Table,
    TaperSection as TaperSection,
    Target as Target,
    Tied as Tied,
    TimeExpression as TimeExpression,
    TimeTable as TimeTable,
    TracedPoint as TracedPoint,
    TubeSection as TubeSection,
    Variable as Variable,
    VariableSection as VariableSection,
    Weld as Weld,
    four_bar as four_bar,
    from_drawing as from_drawing,
    from_pylinkage as from_pylinkage,
    in_case as in_case,
    load as load,
    load_task as load_task,
    manipulator as manipulator,
    quick_return as quick_return,
    refined as refined,
    slider_crank as slider_crank,
    write_scene as write_scene,
)
from fenics_mech.sections import from_sectionproperties as from_sectionproperties
from fenics_mech.studies.design.identify import Identified as Identified, identify as identify
from fenics_mech.studies.design.measured_values import Observation as Observation
from fenics_mech.studies.design.methods import Search as Search
from fenics_mech.studies.design.optimise import Optimum as Optimum, optimise as optimise
from fenics_mech.studies.design.spread import Spread as Spread, spread as spread
from fenics_mech.studies.follow import Branch as Branch, follow as follow
from fenics_mech.studies.gauge import Gauge as Gauge
from fenics_mech.studies.natural_frequencies import NaturalFrequencies as NaturalFrequencies, modes as modes
from fenics_mech.studies.spatial_sweep import sweep_in_space as sweep_in_space
from fenics_mech.studies.sweep import Sweep as Sweep, sweep as sweep
from fenics_mech.studies.synthesis.balancing import balance as balance
from fenics_mech.studies.synthesis.synthesise import (
    Synthesised as Synthesised,
    four_bars as four_bars,
    synthesise as synthesise,
)
from fenics_mech.studies.system_matrices import (
    SystemMatrices as SystemMatrices,
    matrices as matrices,
    participation as participation,
)
from fenics_mech.views.animation import animate as animate
from fenics_mech.views.frequency_views import plot_frequencies as plot_frequencies
from fenics_mech.views.model_plots import animate_modes as animate_modes, plot_mode_shapes as plot_mode_shapes
from fenics_mech.views.model_plots import plot_scene as plot_scene
from fenics_mech.views.notebook import interactive as interactive
from fenics_mech.views.outlines import write_outlines as write_outlines
from fenics_mech.views.page.report import report as report
from fenics_mech.views.plots import (
    plot_deflection as plot_deflection,
    plot_drive as plot_drive,
    plot_joint_forces as plot_joint_forces,
    plot_spectrum as plot_spectrum,
    plot_strain as plot_strain,
    plot_strain_map as plot_strain_map,
)
from fenics_mech.views.result_figures import plot_all as plot_all
from fenics_mech.views.plots import plot_section_forces as plot_section_forces
from fenics_mech.views.summary import summary as summary
from fenics_mech.views.plots import plot_force_path as plot_force_path, plot_point_path as plot_point_path
from fenics_mech.views.workbook import write_workbook as write_workbook
