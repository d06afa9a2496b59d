"""Moving pictures in files: GIF, or MP4 through imageio-ffmpeg, by the path's suffix; whole or absent."""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Iterator
from itertools import chain
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from symdyn.errors import InvalidValue, ResourceProblem
from symdyn.io.files import replacing

Frame = NDArray[np.uint8]
"""(height, width, 3)."""

Progress = Callable[[int, int], None]
"""Called with frames done and frames in all."""

FORMATS = (".gif", ".mp4")

_PALETTE = 128
_LOOKED_AT = 8


def write_video(path: Path, pictures: Iterator[Frame], fps: int) -> None:
    """Write pictures as a file, whole or not at all.

    A GIF's pictures are held in memory until the last is there: they share one palette.

    Args:
        path: of the file.
        pictures: at least one, all of the same even width and height. None is taken before the format is known to work.
        fps: frames a second.

    Raises:
        InvalidValue: if there is no such format.
        ResourceProblem: if MP4 is wanted and imageio-ffmpeg is not installed.
        FileProblem: if the file cannot be written.
    """
    check_format(path)
    write = _write_gif if path.suffix.lower() == ".gif" else _write_mp4
    with replacing(path) as temporary:
        write(temporary, pictures, fps)


def check_format(path: Path) -> None:
    """Whether :func:`write_video` can write this path's format; raises what it raises of that."""
    if path.suffix.lower() not in FORMATS:
        raise InvalidValue("The suffix of an animation's path", path.suffix, f"one of {', '.join(FORMATS)}")
    if path.suffix.lower() == ".mp4":
        try:
            import imageio_ffmpeg  # noqa: F401
        except ModuleNotFoundError:
            raise ResourceProblem(
                "MP4 needs imageio-ffmpeg, which is not installed: pip install imageio-ffmpeg, or write a .gif."
            ) from None


def stretched(factor: float) -> str:
    """How time is stretched, in words.

    Args:
        factor: seconds on screen for a second of what happened.
    """
    return f"slow motion, 1 : {factor:.3g}" if factor >= 1.0 else f"{1.0 / factor:.3g} times as fast"


def _write_gif(path: Path, pictures: Iterator[Frame], fps: int) -> None:
    from PIL import Image

    images = [Image.fromarray(picture) for picture in pictures]
    # one palette for all, from pictures spread over the whole: colours that change between frames flicker
    some = images[:: max(1, len(images) // _LOOKED_AT)]
    width, height = images[0].size
    sheet = Image.new("RGB", (width, height * len(some)))
    for i, image in enumerate(some):
        sheet.paste(image, (0, i * height))
    palette = sheet.quantize(_PALETTE, method=Image.Quantize.MEDIANCUT, dither=Image.Dither.NONE)
    flat = [image.quantize(palette=palette, dither=Image.Dither.NONE) for image in images]
    # ms; the format counts hundredths of a second, and rounding each frame alone would change the speed
    ends = [10 * round(100.0 * (i + 1) / fps) for i in range(len(flat))]
    delays = np.diff([0, *ends]).tolist()
    flat[0].save(path, format="GIF", save_all=True, append_images=flat[1:], duration=delays, loop=0, optimize=False)


def _write_mp4(path: Path, pictures: Iterator[Frame], fps: int) -> None:
    import imageio_ffmpeg

    first = next(pictures)
    height, width = first.shape[:2]
    stream = imageio_ffmpeg.write_frames(
        str(path), (width, height), fps=fps, macro_block_size=2, quality=7, ffmpeg_log_level="error"
    )
    stream.send(None)
    sent = 0
    try:
        for picture in chain([first], pictures):
            stream.send(np.ascontiguousarray(picture))
            sent += 1
    except OSError as error:  # of the pipe to the encoder, which has ended; its own words follow in the text
        words = [line.strip() for line in str(error).splitlines() if line.strip()]
        raise OSError(f"the encoder failed ({words[-1] if words else error})") from error
    finally:
        with contextlib.suppress(OSError):
            stream.close()
    # the encoder keeps frames back, so that what fails with the last of them is told by nothing but the file
    try:
        written, _ = imageio_ffmpeg.count_frames_and_secs(str(path))
    except RuntimeError:
        written = 0
    if written != sent:
        raise OSError(f"the encoder wrote {written} of {sent} frames; the disk may be full")
