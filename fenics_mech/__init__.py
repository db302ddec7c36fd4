"""fenics_mech: dynamics of linkages whose links bend, in the plane and in space.

Everything that a user needs stands here: ``import fenics_mech as fm``, and then ``fm.load``, ``fm.analyse``,
``fm.Scene`` and so on. The command is `fenics-mech`.

Numerical libraries that are loaded after it use one thread, unless the user has set their number. The matrices are
small, and one thread is fastest.
"""

# ruff: noqa: F403, F405

import logging
import os
import sys
from importlib import import_module
from typing import TYPE_CHECKING, Any

from fenics_mech._version import __version__
from fenics_mech.errors import (
    AssemblyError,
    MechanismError,
    ResultError,
    SceneError,
    SolverError,
    TooLargeError,
    UnresolvedError,
    ViewError,
)

logging.getLogger(__name__).addHandler(logging.NullHandler())  # quiet, unless a program asks for the log
os.environ.setdefault("OMP_NUM_THREADS", "1")  # OpenBLAS and MKL follow it, unless their own variables are set
os.environ.setdefault("NUMPY_MADVISE_HUGEPAGE", "0")  # clearing huge pages takes a fifth of the time of large models

if TYPE_CHECKING:
    from fenics_mech.analysis import analyse
    from fenics_mech.recovery import Result
    from fenics_mech.recovery.sound import sound
    from fenics_mech.recovery.spatial_result import SpatialResult
    from fenics_mech.recovery.stress_figures import fatigue
    from fenics_mech.safety import Verdict, judge
    from fenics_mech.safety.load_cases import envelope
    from fenics_mech.scene import *
    from fenics_mech.sections import from_sectionproperties
    from fenics_mech.studies.design.identify import Identified, identify
    from fenics_mech.studies.design.measured_values import Observation
    from fenics_mech.studies.design.methods import Search
    from fenics_mech.studies.design.optimise import Optimum, optimise
    from fenics_mech.studies.design.spread import Spread, spread
    from fenics_mech.studies.follow import Branch, follow
    from fenics_mech.studies.gauge import Gauge
    from fenics_mech.studies.natural_frequencies import NaturalFrequencies, modes
    from fenics_mech.studies.spatial_sweep import sweep_in_space
    from fenics_mech.studies.sweep import Sweep, sweep
    from fenics_mech.studies.synthesis.balancing import balance
    from fenics_mech.studies.synthesis.synthesise import Synthesised, four_bars, synthesise
    from fenics_mech.studies.system_matrices import SystemMatrices, matrices, participation
    from fenics_mech.views.animation import animate
    from fenics_mech.views.frequency_plot import plot_frequencies
    from fenics_mech.views.mode_plots import animate_modes, plot_mode_shapes
    from fenics_mech.views.model_plots import plot_scene
    from fenics_mech.views.notebook import interactive
    from fenics_mech.views.outlines import write_outlines
    from fenics_mech.views.page.report import report
    from fenics_mech.views.plots import (
        plot_deflection,
        plot_drive,
        plot_joint_forces,
        plot_spectrum,
        plot_strain,
        plot_strain_map,
    )
    from fenics_mech.views.result_figures import plot_all
    from fenics_mech.views.section_plots import plot_section_forces
    from fenics_mech.views.summary import summary
    from fenics_mech.views.vector_plots import plot_force_path, plot_point_path
    from fenics_mech.views.workbook import write_workbook

__all__ = [
    "AirDrag",
    "Analysis",
    "AssemblyError",
    "Branch",
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
    "Gauge",
    "GearPair",
    "Ground",
    "GuideClearance",
    "Harmonics",
    "HingeDamper",
    "HingeSpring",
    "ISection",
    "Identified",
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
    "MechanismError",
    "Member",
    "Mesh",
    "Misalignment",
    "MotionTask",
    "Motor",
    "NaturalFrequencies",
    "Notch",
    "Observation",
    "Optimum",
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
    "Result",
    "ResultError",
    "Revolute",
    "RigidBody",
    "RoundSection",
    "Scatter",
    "Scene",
    "SceneError",
    "Search",
    "SideContact",
    "Slot",
    "SolverError",
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
    "SpatialResult",
    "SpatialScene",
    "SpatialTorque",
    "SpeedController",
    "Spread",
    "Stop",
    "StressLife",
    "Study",
    "Sweep",
    "Synthesised",
    "SystemMatrices",
    "Table",
    "TaperSection",
    "Target",
    "Tied",
    "TimeExpression",
    "TimeTable",
    "TooLargeError",
    "TracedPoint",
    "TubeSection",
    "UnresolvedError",
    "Variable",
    "VariableSection",
    "Verdict",
    "ViewError",
    "Weld",
    "__version__",
    "analyse",
    "animate",
    "animate_modes",
    "balance",
    "envelope",
    "fatigue",
    "follow",
    "four_bar",
    "four_bars",
    "from_drawing",
    "from_pylinkage",
    "from_sectionproperties",
    "identify",
    "in_case",
    "interactive",
    "judge",
    "load",
    "load_task",
    "manipulator",
    "matrices",
    "modes",
    "optimise",
    "participation",
    "plot_all",
    "plot_deflection",
    "plot_drive",
    "plot_force_path",
    "plot_frequencies",
    "plot_joint_forces",
    "plot_mode_shapes",
    "plot_point_path",
    "plot_scene",
    "plot_section_forces",
    "plot_spectrum",
    "plot_strain",
    "plot_strain_map",
    "quick_return",
    "refined",
    "report",
    "slider_crank",
    "sound",
    "spread",
    "summary",
    "sweep",
    "sweep_in_space",
    "synthesise",
    "write_outlines",
    "write_scene",
    "write_workbook",
]
NOT_IN_SCENE = {  # modules of the names that are not in the room of that name
    "Branch": "studies.follow",
    "Gauge": "studies.gauge",
    "Identified": "studies.design.identify",
    "NaturalFrequencies": "studies.natural_frequencies",
    "Observation": "studies.design.measured_values",
    "Optimum": "studies.design.optimise",
    "Result": "recovery",
    "Search": "studies.design.methods",
    "SpatialResult": "recovery.spatial_result",
    "Spread": "studies.design.spread",
    "Sweep": "studies.sweep",
    "Synthesised": "studies.synthesis.synthesise",
    "SystemMatrices": "studies.system_matrices",
    "Verdict": "safety",
    "analyse": "analysis",
    "animate": "views.animation",
    "animate_modes": "views.mode_plots",
    "balance": "studies.synthesis.balancing",
    "envelope": "safety.load_cases",
    "fatigue": "recovery.stress_figures",
    "follow": "studies.follow",
    "four_bars": "studies.synthesis.synthesise",
    "from_sectionproperties": "sections",
    "identify": "studies.design.identify",
    "judge": "safety",
    "interactive": "views.notebook",
    "modes": "studies.natural_frequencies",
    "matrices": "studies.system_matrices",
    "optimise": "studies.design.optimise",
    "participation": "studies.system_matrices",
    "plot_all": "views.result_figures",
    "plot_deflection": "views.plots",
    "plot_drive": "views.plots",
    "plot_force_path": "views.vector_plots",
    "plot_frequencies": "views.frequency_plot",
    "plot_joint_forces": "views.plots",
    "plot_mode_shapes": "views.mode_plots",
    "plot_point_path": "views.vector_plots",
    "plot_scene": "views.model_plots",
    "plot_section_forces": "views.section_plots",
    "plot_spectrum": "views.plots",
    "plot_strain": "views.plots",
    "plot_strain_map": "views.plots",
    "report": "views.page.report",
    "sound": "recovery.sound",
    "spread": "studies.design.spread",
    "summary": "views.summary",
    "sweep": "studies.sweep",
    "sweep_in_space": "studies.spatial_sweep",
    "synthesise": "studies.synthesis.synthesise",
    "write_outlines": "views.outlines",
    "write_workbook": "views.workbook",
}


def __getattr__(name: str) -> Any:
    """Import what is asked for, and no more: dolfinx takes a second, and the command must be able to be interrupted."""
    if name in __all__:
        return getattr(import_module(f"{__name__}.{NOT_IN_SCENE.get(name, 'scene')}"), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


def __dir__() -> list[str]:
    return __all__


def _html(shown: Any) -> str:
    """Write a scene or a result as HTML."""
    return str(import_module(f"{__name__}.views.notebook").html(shown))


def _show_in_notebooks() -> None:
    """Let notebooks show scenes and results as tables; neither class need know of views, which come after them."""
    shell = sys.modules["IPython"].get_ipython() if "IPython" in sys.modules else None
    if shell is not None:
        formatter = shell.display_formatter.formatters["text/html"]
        for module, name in (("scene.models", "Scene"), ("recovery.result", "Result")):
            formatter.for_type_by_name(f"{__name__}.{module}", name, _html)


_show_in_notebooks()
