"""What a notebook shows of a scene and of a result: the text of `check` and of `run`, and the page in a frame."""

from __future__ import annotations

from dataclasses import dataclass
from html import escape

from rich.console import Group
from rich.text import Text

from fenics_mech._console import html_of
from fenics_mech.errors import MechanismError, ViewError
from fenics_mech.machine.reach import reachable_range
from fenics_mech.recovery import Result
from fenics_mech.recovery.spatial_result import SpatialResult
from fenics_mech.scene import Scene
from fenics_mech.scene.in_space import SpatialScene
from fenics_mech.views.page.report import page
from fenics_mech.views.reading import reading_of_a_file
from fenics_mech.views.space.overview import spatial_overview
from fenics_mech.views.space.page import spatial_page
from fenics_mech.views.summary import summary
from fenics_mech.views.tables import scene_overview

AnyScene = Scene | SpatialScene


def html(shown: AnyScene | Result | SpatialResult) -> str:
    """Write a scene or a result as HTML."""
    # A scene that cannot be assembled, and a result of which parts are missing, are shown by name and reason.
    try:
        if isinstance(shown, Scene):
            return html_of(scene_overview(shown, reachable_range(shown)))
        return html_of(spatial_overview(shown) if isinstance(shown, SpatialScene) else summary(shown))
    except MechanismError as error:
        name = shown.name if isinstance(shown, AnyScene) else str(shown.data.attrs.get("title", "result"))
        return html_of(Group(Text(name, style="bold"), Text(str(error), style="red")))


@dataclass(frozen=True)
class InFrame:
    """A page that a notebook shows in a frame, where it can do nothing but run its own script and save its curves."""

    page: str  # the page's HTML
    height: int  # height of the frame (pixels)

    def _repr_html_(self) -> str:
        """HTML of the frame, which notebooks ask for by this name."""
        look = f"width: 100%; height: {self.height}px; border: 0"
        return f'<iframe sandbox="allow-scripts allow-downloads" style="{look}" srcdoc="{escape(self.page)}"></iframe>'


def interactive(result: Result | SpatialResult, height: int = 900) -> InFrame:
    """Show the report of a result below a cell: the mechanism turns, and curves and maps follow its slider.

    Parameters
    ----------
    result
        The result.
    height
        Height of the frame (pixels).

    Returns
    -------
    InFrame
        The page, which a notebook shows where it stands last in a cell.

    Raises
    ------
    ViewError
        When the height is not positive.
    ResultError
        When the result lacks what is shown.

    Examples
    --------
    >>> shown = fm.interactive(fm.Result.load("out/result.nc"), height=700)
    >>> "DecompressionStream" in shown.page
    True
    """
    if not height > 0:
        raise ViewError(f"height must be a positive number of pixels, found {height}")
    with reading_of_a_file():
        return InFrame(spatial_page(result) if isinstance(result, SpatialResult) else page(result), int(height))
