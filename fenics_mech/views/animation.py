"""Animation of a mechanism over one turn of its drive: deflection magnified, coloured by stress or strain."""

from __future__ import annotations

import itertools
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
from fenics_mech.views.drawn_parts import ground_points, guides_of, load_names, motion_of
from fenics_mech.views.frames import cycle, default_magnification, frames_at, moment_of_peak, peak_of
from fenics_mech.views.reading import reading_of, reading_of_a_file
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
Progress = Callable[[int, int], None]
COLOURED = ("stress", "strain")
NEARLY_WHITE = 248  # of 255: colours of a palette that are as bright are made white


def animate(
    result: Result,
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
        The result.
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
    if magnify is not None and not (math.isfinite(magnify) and magnify >= 0):
        raise ViewError(f"magnify must be a number that is not negative, found {magnify}")
    for name, value in (("frames", frames), ("fps", fps), ("width", size[0]), ("height", size[1])):
        if value < 1:
            raise ViewError(f"{name} must be at least 1, found {value}")
    if colour not in COLOURED:
        raise ViewError(f"colours show {' or '.join(COLOURED)}, found {colour!r}")
    if "link_position" not in result.data:
        raise ViewError("the result has no positions: an older version wrote it. Analyse its scene again")
    prepare_rendering()
    if ending == ".mp4":
        size = (size[0] + size[0] % 2, size[1] + size[1] % 2)
    at = np.array([moment_of_peak(result, colour)]) if ending == ".png" else cycle(result, frames)
    factor = default_magnification(result) if magnify is None else magnify
    pictures = _pictures(result, at, factor, size, colour, names, true_width, progress)
    try:
        write_whole(path, lambda temporary: WRITERS[ending](temporary, pictures, fps))
    finally:
        pictures.close()
    return path


def check_ending(path: Path) -> str:
    """Give the ending of an animation's file in small letters."""
    ending = path.suffix.lower()
    if ending not in WRITERS:
        raise ViewError(f"{path}: an animation's file must end in one of {', '.join(WRITERS)}, not in {path.suffix!r}")
    return ending


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


def _write_gif(path: Path, pictures: Pictures, fps: int) -> None:
    """Write with one palette for all, that of the first picture: its colour bar has every colour but the symbols'."""
    first = Image.fromarray(next(pictures))
    palette = _palette(first)
    first, *rest = (
        picture.quantize(palette=palette, dither=Image.Dither.NONE)
        for picture in itertools.chain([first], map(Image.fromarray, pictures))
    )
    first.save(path, save_all=True, append_images=rest, duration=1000 / fps, loop=0)


def _palette(picture: Image.Image) -> Image.Image:
    """Give an image with the colours of a picture, those of symbols that may come later, and pure white."""
    from fenics_mech.views.stage import SYMBOLS  # noqa: PLC0415 - VTK is loaded only where something is rendered

    shown = picture.copy()
    side = max(1, min(shown.size) // 30)
    for i, colour in enumerate(SYMBOLS):
        shown.paste(colour, (i * side, 0, (i + 1) * side, side))
    found = shown.quantize(256, method=Image.Quantize.MAXCOVERAGE)
    colours = np.array(found.getpalette()).reshape(-1, 3)
    colours[(colours > NEARLY_WHITE).all(axis=1)] = 255
    found.putpalette(colours.ravel().tolist())
    return found


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
    ".png": lambda path, pictures, fps: Image.fromarray(next(pictures)).save(path),
}
