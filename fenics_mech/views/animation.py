"""Animation of a mechanism over one turn of its drive: deflection magnified, coloured by strain."""

from __future__ import annotations

import math
from collections.abc import Callable, Generator
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from fenics_mech._arrays import Array
from fenics_mech._files import write_whole
from fenics_mech.errors import ViewError
from fenics_mech.recovery import Result
from fenics_mech.views.frames import angle_of_peak, cycle, default_magnification, frames_at, strain_limit
from fenics_mech.views.joint_drawings import ground_guides, ground_points
from fenics_mech.views.rendering import prepare_rendering
from fenics_mech.views.tables import drive_of
from fenics_mech.views.words import short

try:
    import imageio.v2 as imageio
    import pyvista  # noqa: F401
    from imageio_ffmpeg import count_frames_and_secs
except ImportError as error:
    raise ViewError(f"animations need pyvista and imageio: pip install 'fenics_mech[views]' ({error})") from error

Pictures = Generator[NDArray[np.uint8], None, None]
GUIDE_POSITIONS = 120  # over the cycle, to find a slider's travel
Progress = Callable[[int, int], None]


def animate(
    result: Result,
    path: str | Path,
    *,
    magnify: float | None = None,
    frames: int = 120,
    fps: int = 30,
    size: tuple[int, int] = (960, 720),
    names: bool = False,
    progress: Progress = lambda frame, frames: None,
) -> Path:
    """Animate a mechanism over one turn, off screen.

    Parameters
    ----------
    result
        The result.
    path
        File to write: .gif, .mp4, or .png for one picture at the largest strain.
    magnify
        Factor on the deflection; by default a round one that draws the largest deflection at about 8 % of the
        linkage's size. The picture says which.
    frames
        Number of pictures over the turn.
    fps
        Pictures per second.
    size
        Width and height (pixels); for MP4 they are rounded up to even numbers.
    names
        Whether the joints' names are written beside them.
    progress
        Called before each picture with its index, from 0, and the number of pictures.

    Returns
    -------
    Path
        The file that was written.

    Raises
    ------
    ViewError
        When the file's ending is not known, an option is not usable, no link bends, or this machine cannot render.
    ResultError
        When the file cannot be written.

    Examples
    --------
    >>> result = fm.Result.load("out/result.nc")
    >>> fm.animate(result, "motion.mp4", magnify=20)  # doctest: +SKIP
    PosixPath('motion.mp4')
    """
    path = Path(path)
    ending = check_ending(path)
    _check_options(magnify, frames, fps, size)
    if "deflection" not in result.data:
        raise ViewError("no link of the scene bends, and an animation shows how links bend")
    prepare_rendering()
    if ending == ".mp4":
        size = (size[0] + size[0] % 2, size[1] + size[1] % 2)
    theta = np.array([angle_of_peak(result)]) if ending == ".png" else cycle(result, frames)
    factor = default_magnification(result) if magnify is None else magnify
    joints = tuple(result.scene.joints) if names else ()
    pictures = _pictures(result, (theta, factor), size, joints, progress)
    try:
        write_whole(path, lambda temporary: WRITERS[ending](temporary, pictures, fps))
    finally:
        pictures.close()
    return path


def check_ending(path: Path) -> str:
    """Give the ending of an animation's file in small letters.

    Raises
    ------
    ViewError
        When no animation is written with this ending.
    """
    ending = path.suffix.lower()
    if ending not in WRITERS:
        raise ViewError(f"{path}: an animation's file must end in one of {', '.join(WRITERS)}, not in {path.suffix!r}")
    return ending


def _check_options(magnify: float | None, frames: int, fps: int, size: tuple[int, int]) -> None:
    if magnify is not None and not (math.isfinite(magnify) and magnify >= 0):
        raise ViewError(f"magnify must be a number that is not negative, found {magnify}")
    for name, value in (("frames", frames), ("fps", fps), ("width", size[0]), ("height", size[1])):
        if value < 1:
            raise ViewError(f"{name} must be at least 1, found {value}")


def _pictures(
    result: Result, drawn: tuple[Array, float], size: tuple[int, int], names: tuple[str, ...], progress: Progress
) -> Pictures:
    """Render the mechanism at drive angles with a magnification, one picture after the other."""
    from fenics_mech.views.stage import Stage  # noqa: PLC0415 - VTK is loaded only where something is rendered

    theta, magnify = drawn
    scene, shown = result.scene, frames_at(result, theta, magnify)
    driven = drive_of(scene) if len(scene.drives) < 2 else f"{len(scene.drives)} drives; period {scene.period:.4g} s"
    title = f"{scene.name}, {driven}"
    at = f"{short(shown.peak_strain)} \N{MICRO SIGN}m/m at {np.degrees(angle_of_peak(result)) % 360:.0f}\N{DEGREE SIGN}"
    caption = f"ring: largest strain of the motion on the + side, {at}\n"
    caption += f"deflection \N{MULTIPLICATION SIGN} {magnify:.4g}; colour: strain on the + side; grey: rigid linkage"
    ground = (ground_points(scene), ground_guides(scene, cycle(result, GUIDE_POSITIONS)))
    stage = Stage(shown, ground, size, strain_limit(result), names, (title, caption))
    try:
        for index in range(len(theta)):
            progress(index, len(theta))
            yield stage.picture(index)
    finally:
        stage.close()


def _write_png(path: Path, pictures: Pictures, fps: int) -> None:
    Image.fromarray(next(pictures)).save(path)


def _write_gif(path: Path, pictures: Pictures, fps: int) -> None:
    """Write with one palette for all, that of the first picture: its colour bar has every colour."""
    first = Image.fromarray(next(pictures)).quantize(256, method=Image.Quantize.MAXCOVERAGE)
    rest = (Image.fromarray(picture).quantize(palette=first, dither=Image.Dither.NONE) for picture in pictures)
    first.save(path, save_all=True, append_images=rest, duration=1000 / fps, loop=0)


def _write_mp4(path: Path, pictures: Pictures, fps: int) -> None:
    """Write through ffmpeg, which does not tell when a disk is full: so the pictures in the file are counted."""
    options: dict[str, Any] = {"quality": 8, "macro_block_size": 2, "ffmpeg_log_level": "quiet"}
    writer: Any = imageio.get_writer(path, format="FFMPEG", mode="I", fps=fps, **options)  # type: ignore[arg-type]
    count = 0
    with writer:
        for count, picture in enumerate(pictures, 1):  # noqa: B007
            writer.append_data(picture)
    try:
        written, _ = count_frames_and_secs(path)
    except RuntimeError as error:
        raise OSError("ffmpeg could not write it whole; the disk may be full") from error
    if written != count:
        raise OSError(f"ffmpeg wrote {written} of {count} pictures; the disk may be full")


WRITERS: dict[str, Callable[[Path, Pictures, int], None]] = {
    ".gif": _write_gif,
    ".mp4": _write_mp4,
    ".png": _write_png,
}
