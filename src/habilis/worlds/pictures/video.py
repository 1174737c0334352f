"""Videos of episodes: GIF for pages and mails, MP4 for browsers and slides."""

import subprocess
from collections.abc import Callable, Iterator, Sequence
from fractions import Fraction
from itertools import chain, repeat
from pathlib import Path
from tempfile import TemporaryDirectory, TemporaryFile
from typing import Any, cast

import numpy as np
from jaxtyping import UInt8
from PIL import Image

from habilis.extras import MissingExtraError, import_from
from habilis.files import suffix_of, write_whole
from habilis.worlds.pictures.figures import Drawn, frame
from habilis.worlds.pictures.tiles import Tiles
from habilis.worlds.world import World

Frame = UInt8[np.ndarray, "height width 3"]
Frames = Sequence[Frame] | UInt8[np.ndarray, "frames height width 3"]
States = Sequence[World] | Sequence[Drawn] | Frames

_REST = 6  # how many times longer a video stays on its last frame
_TICK, _LONGEST = 10, 655_350  # milliseconds: a GIF counts hundredths, in 16 bits
_COLOURS = "bt709"  # said in the file, so that players do not guess


def save_video(states: States, path: str | Path, cell: int = 32, milliseconds: int = 250) -> None:
    """Writes an episode as a video, a GIF or an MP4 by the suffix, that rests on its last state.

    Args:
        states: states of one world or puzzle in order (of a puzzle as `puzzle.at(state)`), or
            pictures of one size, red, green and blue.
        path: ends with .gif (repeats for ever) or .mp4 (H.264; needs the extra `habilis[video]`).
        cell: pixels a cell, where states are given.
        milliseconds: how long a state stays on.

    Raises:
        ValueError: another suffix, no states, states of several worlds, no picture's shape, or
            no time; nothing is written.
        MissingExtraError: an .mp4 without the extra.

    Example:
        >>> import habilis as hb
        >>> world = hb.load_world("corridor")
        >>> mdp = hb.tabulate(world)
        >>> plan = hb.solve(mdp)
        >>> states = [hb.placement(world, mdp, state) for state in plan.states]
        >>> hb.save_video(states, "plan.gif")  # doctest: +SKIP
    """
    _SAVERS[suffix_of(path, _SAVERS)](states, path, cell, milliseconds)


def save_gif(states: States, path: str | Path, cell: int = 32, milliseconds: int = 250) -> None:
    """Writes a GIF that repeats for ever (see `save_video`).

    Equal neighbours share a frame that stays on for both.
    """
    suffix_of(path, [".gif"])
    first, last, frames = _checked(states, path, cell, milliseconds)
    if milliseconds < _TICK or _REST * milliseconds > _LONGEST:
        raise ValueError(
            f"{path}: milliseconds is {milliseconds}; a GIF takes {_TICK} to {_LONGEST // _REST}"
        )
    # One palette, so that still things do not flicker; a world's ends have all its colours.
    colours = np.concatenate([first, last])
    if not isinstance(states[0], World | Drawn):
        everywhere = _colours(cast(Frames, states))
        if everywhere.size > _colours([first, last]).size:
            colours = everywhere
    palette = Image.fromarray(colours).quantize(method=Image.Quantize.FASTOCTREE)
    images = (
        Image.fromarray(pixels).quantize(palette=palette, dither=Image.Dither.NONE)
        for pixels in frames
    )
    durations = [milliseconds] * (len(states) - 1) + [_REST * milliseconds]
    image = next(images)
    how: Any = {"append_images": images, "duration": durations, "loop": 0}
    write_whole(path, lambda file: image.save(file, format="GIF", save_all=True, **how))


def save_mp4(states: States, path: str | Path, cell: int = 32, milliseconds: int = 250) -> None:
    """Writes an MP4 that plays everywhere: H.264, even sizes, 4:2:0 (see `save_video`).

    A picture of odd width or height is repeated at its last column or row.
    """
    suffix_of(path, [".mp4"])
    first, last, frames = _checked(states, path, cell, milliseconds)
    height, width = (side + side % 2 for side in first.shape[:2])
    rate = str(Fraction(1000, milliseconds))
    encoder = check_video()
    with TemporaryDirectory() as folder, TemporaryFile() as complaints:
        video = Path(folder) / "video.mp4"
        command = [  # ffmpeg below 7.1 converts to the colours given by "scale" only
            *(encoder, "-loglevel", "error"),
            *("-f", "rawvideo", "-pix_fmt", "rgb24", "-s", f"{width}x{height}", "-r", rate),
            *("-i", "-", "-vf", f"scale=out_color_matrix={_COLOURS}:out_range=tv"),
            *("-c:v", "libx264", "-crf", "16", "-pix_fmt", "yuv420p"),
            *("-colorspace", _COLOURS, "-color_primaries", _COLOURS, "-color_trc", _COLOURS),
            *("-movflags", "+faststart", str(video)),
        ]
        with subprocess.Popen(command, stdin=subprocess.PIPE, stderr=complaints) as process:
            assert process.stdin is not None
            try:
                for pixels in chain(frames, repeat(last, _REST - 1)):
                    odd = [(0, side % 2) for side in pixels.shape[:2]]
                    process.stdin.write(np.pad(pixels, [*odd, (0, 0)], "edge").tobytes())
            except BrokenPipeError:
                pass  # why, ffmpeg has said
        if process.returncode:
            complaints.seek(0)
            raise OSError(f"ffmpeg: {complaints.read().decode(errors='replace').strip()}")
        write_whole(path, lambda file: file.write(video.read_bytes()))


def check_video() -> str:
    """The program that encodes an MP4.

    Raises:
        MissingExtraError: it is not installed.
    """
    video = import_from("imageio_ffmpeg", extra="video")
    try:
        return video.get_ffmpeg_exe()
    except RuntimeError:
        raise MissingExtraError(
            "ffmpeg is not installed; run: pip install 'habilis[video]', or set "
            "IMAGEIO_FFMPEG_EXE to its path"
        ) from None


_SAVERS: dict[str, Callable[[States, str | Path, int, int], None]] = {
    ".gif": save_gif,
    ".mp4": save_mp4,
}


def _checked(
    states: States, path: str | Path, cell: int, milliseconds: int
) -> tuple[Frame, Frame, Iterator[Frame]]:
    """The first frame, the last, and all of them one after the other."""
    if not len(states):
        raise ValueError(f"{path}: a video of no states; give at least one")
    for name, number in (("milliseconds", milliseconds), ("cell", cell)):
        if isinstance(number, bool) or not isinstance(number, int) or number < 1:
            raise ValueError(f"{path}: {name} is {number!r}; give a whole number of at least 1")
    if isinstance(states[0], World):
        return _of_worlds(cast(Sequence[World], states), path, cell)
    if isinstance(states[0], Drawn):
        return _of_drawn(cast(Sequence[Drawn], states), path, cell)
    return _of_pictures(cast(Frames, states), path)


def _of_worlds(
    states: Sequence[World], path: str | Path, cell: int
) -> tuple[Frame, Frame, Iterator[Frame]]:
    def still(world: World) -> tuple:
        things = (*((thing.kind, thing.goal) for thing in world.objects),)
        tools = (*(tool.kind for tool in world.tools),)
        return world.height, world.width, world.walls, things, tools

    for number, state in enumerate(states):
        if not isinstance(state, World) or still(state) != still(states[0]):
            raise ValueError(
                f"{path}: state {number} is of another world than state 0; "
                "give states that differ in where agent, tool and can are"
            )
    tiles = Tiles.of(states[0], cell)
    return tiles.picture(states[0]), tiles.picture(states[-1]), map(tiles.picture, states)


def _of_drawn(
    states: Sequence[Drawn], path: str | Path, cell: int
) -> tuple[Frame, Frame, Iterator[Frame]]:
    def still(puzzle: Drawn) -> tuple:
        return puzzle.name, puzzle.height, puzzle.width, puzzle.walls

    for number, state in enumerate(states):
        if not isinstance(state, Drawn) or still(state) != still(states[0]):
            raise ValueError(
                f"{path}: state {number} is of another puzzle than state 0; give states that "
                "differ in where the bodies are"
            )
    return frame(states[0], cell), frame(states[-1], cell), (frame(one, cell) for one in states)


def _of_pictures(pictures: Frames, path: str | Path) -> tuple[Frame, Frame, Iterator[Frame]]:
    frames = [np.asarray(picture) for picture in pictures]
    for number, pixels in enumerate(frames):
        if pixels.dtype != np.uint8 or pixels.shape != (*frames[0].shape[:2], 3):
            raise ValueError(
                f"{path}: picture {number} has shape {pixels.shape} and type {pixels.dtype}; "
                "give uint8 of one shape [height, width, 3]"
            )
    return frames[0], frames[-1], iter(frames)


def _colours(pictures: Frames) -> UInt8[np.ndarray, "1 colours 3"]:
    """Every colour that there is in some pictures."""
    found = np.empty(0, np.int64)
    for pixels in pictures:
        found = np.union1d(found, np.asarray(pixels).reshape(-1, 3) @ (1 << 16, 1 << 8, 1))
    return np.stack([found >> 16, found >> 8 & 255, found & 255], axis=-1).astype(np.uint8)[None]
