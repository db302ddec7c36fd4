"""Can this machine render without a display? VTK ends the process when it cannot, so another process tries first."""

from __future__ import annotations

import os
import subprocess
import sys
from functools import cache

from fenics_mech.errors import ViewError

VARIABLE = "VTK_DEFAULT_OPENGL_WINDOW"
WINDOWS = ("vtkEGLRenderWindow", "vtkOSOpenGLRenderWindow", "vtkXOpenGLRenderWindow")  # in the order they are tried
PROBE = """
import vtkmodules.vtkRenderingOpenGL2
from vtkmodules.vtkRenderingCore import vtkRenderWindow
window = vtkRenderWindow()
window.SetOffScreenRendering(1)
window.Render()
raise SystemExit(not window.SupportsOpenGL())
"""
PATIENCE = 60.0  # seconds


def prepare_rendering() -> None:
    """Choose a kind of render window that works here, unless the user has chosen one."""
    # On Linux the choice is left in the environment variable ``VTK_DEFAULT_OPENGL_WINDOW``, where VTK looks for it.
    chosen = os.environ.get(VARIABLE, "")
    if chosen or sys.platform != "linux":
        if not can_render(chosen):
            raise ViewError(f"pyvista cannot render here{f' with {VARIABLE}={chosen}' if chosen else ''}. {_advice()}")
        return
    working = next(filter(can_render, WINDOWS), None)
    if working is None:
        raise ViewError(f"pyvista cannot render here: neither EGL, nor OSMesa, nor an X display works. {_advice()}")
    os.environ[VARIABLE] = working


@cache
def can_render(window: str) -> bool:
    """Try in a process of its own whether VTK renders with a kind of window ("": what VTK takes by itself)."""
    environment = os.environ | {VARIABLE: window} if window else None
    try:
        return not subprocess.run(
            [sys.executable, "-P", "-c", PROBE], env=environment, capture_output=True, timeout=PATIENCE, check=False
        ).returncode
    except subprocess.TimeoutExpired:
        return False


def _advice() -> str:
    if sys.platform != "linux":
        return f"Install VTK's graphics drivers, or clear {VARIABLE}"
    return f"Install EGL (Debian: apt-get install libegl1 libgl1-mesa-dri), and clear {VARIABLE} if it is set"
