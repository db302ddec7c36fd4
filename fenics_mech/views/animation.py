"""Animation of a mechanism over one turn of its drive: deflection magnified, coloured by stress or strain."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from fenics_mech._arrays import Array
from fenics_mech.errors import ViewError
from fenics_mech.recovery import Result
from fenics_mech.recovery.spatial_result import SpatialResult
from fenics_mech.views.drawn_parts import ground_points, guides_of, load_names, motion_of
from fenics_mech.views.frames import cycle, default_magnification, frames_at, moment_of_peak, peak_of
from fenics_mech.views.picture_files import Pictures, Progress, check_ending, check_options, even, write_pictures
from fenics_mech.views.reading import reading_of, reading_of_a_file
from fenics_mech.views.rendering import prepare_rendering
from fenics_mech.views.tables import drive_of
from fenics_mech.views.words import short

COLOURED = ("stress", "strain")


def animate(
    result: Result | SpatialResult,
    path: str | Path,
    *,
    magnify: float | None = None,
    frames: int = 120,
    fps: int = 30,
    size: tuple[int, int] = (960, 720),
    colour: str = "stress",
    names: bool = False,
    true_width: bool = False,
    progress: Progress = lambda frame, frames: None,
) -> Path:
    """Animate a mechanism over one turn, or over a motion in time, off screen.

    Each side of a member has the colour of its stress. A ring marks the peak that the run tells.
    Trails show where joints and the points in the scene's `[points]` go. Grey discs are point masses, as large as their
    share of the largest; arrows are loads at points, and end where they act.

    Parameters
    ----------
    result
        The result. In space beams have their true sections, and each place of them its own colour.
    path
        File to write: .gif, .mp4, or .png for one picture at the peak.
    magnify
        Factor on the deflection; by default a round one that draws the largest deflection at about 8 % of the
        linkage's size. The picture says which.
    frames
        Number of pictures over the turn.
    fps
        Pictures per second.
    size
        Width and height (pixels); for MP4 they are rounded up to even numbers.
    colour
        What the colours show: "stress" or "strain".
    names
        Whether joints, points of the scene's `[points]` and loads have their names beside them.
    true_width
        Whether members are as wide as their sections in the plane of motion, not all alike.
    progress
        Called before each picture with its index, from 0, and the number of pictures.

    Returns
    -------
    Path
        The file that was written.

    Raises
    ------
    ViewError
        When the file's ending is not known, an option is not usable, or this machine cannot render.
    ResultError
        When the result lacks what is shown, or the file cannot be written.

    Examples
    --------
    >>> result = fm.Result.load("out/result.nc")
    >>> fm.animate(result, "motion.mp4", magnify=20)  # doctest: +SKIP
    PosixPath('motion.mp4')
    """
    path = Path(path)
    ending = check_ending(path)
    check_options(magnify, frames, fps, size)
    if colour not in COLOURED:
        raise ViewError(f"colours show {' or '.join(COLOURED)}, found {colour!r}")
    size = even(size) if ending == ".mp4" else size
    if isinstance(result, SpatialResult):
        prepare_rendering()
        from fenics_mech.views.space.animation import spatial_animation  # noqa: PLC0415 - VTK is loaded only where used

        return spatial_animation(result, path, (colour, magnify, frames, names), fps, size, progress)
    if "link_position" not in result.data:
        raise ViewError("the result has no positions: an older version wrote it. Analyse its scene again")
    prepare_rendering()
    at = np.array([moment_of_peak(result, colour)]) if ending == ".png" else cycle(result, frames)
    factor = default_magnification(result) if magnify is None else magnify
    pictures = _pictures(result, at, factor, size, colour, names, true_width, progress)
    return write_pictures(path, pictures, fps)


def _pictures(
    result: Result,
    at: Array,
    factor: float,
    size: tuple[int, int],
    colour: str,
    names: bool,
    true_width: bool,
    progress: Progress,
) -> Pictures:
    """Render the mechanism at instants with a magnification, one picture after the other."""
    from fenics_mech.views.stage import Stage  # noqa: PLC0415 - VTK is loaded only where something is rendered

    scene = result.scene
    with reading_of_a_file():
        shown, peak = frames_at(result, at, factor, colour), peak_of(result, colour)
    driven = drive_of(scene) if len(scene.drives) < 2 else f"{len(scene.drives)} drives; period {scene.period:.4g} s"
    ground = (ground_points(scene), guides_of(scene, motion_of(result)))
    unit = reading_of(result).units.label(colour)
    written = (*scene.joints, *scene.points, *load_names(scene)) if names else ()
    limit, caption = 1.0, "links do not bend"
    if peak is not None:
        limit = peak.limit
        caption = (
            f"ring: {colour} {short(peak.value)} {unit} {peak.words}\n"
            f"deflection \N{MULTIPLICATION SIGN} {factor:.4g}, of paths \N{MULTIPLICATION SIGN} 1; "
            f"colour: {colour} of each side; grey: rigid linkage"
        )
    text = f"{scene.name}, {driven}", caption
    stage = Stage(shown, ground, size, limit, f"{colour} ({unit})", text, written, true_width)
    try:
        for index in range(len(shown.labels)):
            progress(index, len(shown.labels))
            yield stage.picture(index)
    finally:
        stage.close()
