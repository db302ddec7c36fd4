"""What a notebook shows of a scene and of a result: the text of `check` and of `run`."""

from __future__ import annotations

from rich.console import Group
from rich.text import Text

from fenics_mech._console import html_of
from fenics_mech.errors import MechanismError
from fenics_mech.kinematics import reachable_range
from fenics_mech.recovery import Result
from fenics_mech.scene import Scene
from fenics_mech.views.summary import summary
from fenics_mech.views.tables import scene_overview


def html(shown: Scene | Result) -> str:
    """Write a scene or a result as HTML.

    A scene that cannot be assembled, and a result of which parts are missing, are shown by name and reason.

    Parameters
    ----------
    shown
        The scene, or the result.

    Examples
    --------
    >>> from fenics_mech.views.notebook import html
    >>> html(fm.load("demos/four_bar.toml")).startswith("<pre")
    True
    """
    try:
        return html_of(scene_overview(shown, reachable_range(shown)) if isinstance(shown, Scene) else summary(shown))
    except MechanismError as error:
        name = shown.name if isinstance(shown, Scene) else str(shown.data.attrs.get("title", "result"))
        return html_of(Group(Text(name, style="bold"), Text(str(error), style="red")))
