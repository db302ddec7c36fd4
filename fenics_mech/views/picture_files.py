"""Files of moving pictures: GIF, MP4, and PNG of one."""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Generator
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from fenics_mech._files import write_whole
from fenics_mech.errors import ViewError

try:
    import imageio.v2 as imageio
    import pyvista  # noqa: F401
    from imageio_ffmpeg import count_frames_and_secs
except ImportError as error:
    raise ViewError(f"animations need pyvista and imageio: pip install 'fenics_mech[views]' ({error})") from error

Pictures = Generator[NDArray[np.uint8], None, None]
Progress = Callable[[int, int], None]
NEARLY_WHITE = 248  # of 255: colours of a palette that are as bright are made white


def write_pictures(path: Path, pictures: Pictures, fps: int) -> Path:
    """Write pictures to a file by its ending, as a whole or not at all."""
    try:
        write_whole(path, lambda temporary: WRITERS[check_ending(path)](temporary, pictures, fps))
    finally:
        pictures.close()
    return path


def check_ending(path: Path) -> str:
    """Give the ending of an animation's file in small letters."""
    ending = path.suffix.lower()
    if ending not in WRITERS:
        raise ViewError(f"{path}: an animation's file must end in one of {', '.join(WRITERS)}, not in {path.suffix!r}")
    return ending


def even(size: tuple[int, int]) -> tuple[int, int]:
    """Width and height rounded up to even numbers, which MP4 needs."""
    return (size[0] + size[0] % 2, size[1] + size[1] % 2)


def check_options(magnify: float | None, frames: int, fps: int, size: tuple[int, int]) -> None:
    """Raise `ViewError` where a number of an animation is not usable."""
    if magnify is not None and not (math.isfinite(magnify) and magnify >= 0):
        raise ViewError(f"magnify must be a number that is not negative, found {magnify}")
    for name, value in (("frames", frames), ("fps", fps), ("width", size[0]), ("height", size[1])):
        if value < 1:
            raise ViewError(f"{name} must be at least 1, found {value}")


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
