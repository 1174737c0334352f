"""A video shows the frames it was given: the file is read back and looked at."""

import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import imageio_ffmpeg
import numpy as np
import pytest
from PIL import Image, ImageSequence
from video import read_mp4

import habilis as hb
from habilis.extras import MissingExtraError
from habilis.worlds.pictures.figures import frame
from habilis.worlds.pictures.video import save_gif, save_mp4, save_video
from habilis.worlds.world import World

ROOM = World.parse("#####G\n#.....\n#..AP.\n#....C\n", name="room")


def walk() -> list[World]:
    bare = ROOM.with_tool("none")
    return [replace(bare, agent=(1, column)) for column in range(1, 5)]


def frames_of(path: Path) -> list[Image.Image]:
    with Image.open(path) as video:
        return [image.copy() for image in ImageSequence.Iterator(video)]


def test_a_gif_has_a_frame_per_state_and_rests_on_the_last(tmp_path: Path):
    save_gif(walk(), tmp_path / "walk.gif", cell=20, milliseconds=100)
    frames = frames_of(tmp_path / "walk.gif")
    assert [image.size for image in frames] == [(120, 80)] * 4
    durations = [image.info["duration"] for image in frames]
    assert durations[:3] == [100] * 3
    assert durations[3] > 300


def test_still_things_do_not_flicker_in_a_video(tmp_path: Path):
    save_gif(walk(), tmp_path / "walk.gif")
    pictures = [np.asarray(image.convert("RGB")) for image in frames_of(tmp_path / "walk.gif")]
    can = np.s_[3 * 32 : 4 * 32, 5 * 32 : 6 * 32]
    assert len({picture[can].tobytes() for picture in pictures}) == 1


def test_a_video_keeps_the_colours_of_its_frames(tmp_path: Path):
    states = [*walk(), ROOM.with_tool("none").with_cells(object=ROOM.goal)]
    save_gif(states, tmp_path / "walk.gif")
    for state, image in zip(states, frames_of(tmp_path / "walk.gif"), strict=True):
        error = np.abs(np.asarray(image.convert("RGB")).astype(int) - frame(state))
        assert error.max() < 40
        assert error.mean() < 2


def told_of(path: Path) -> str:
    """ffmpeg's report on a file."""
    ffmpeg = imageio_ffmpeg.get_ffmpeg_exe()
    return subprocess.run([ffmpeg, "-i", path], capture_output=True, text=True).stderr


def test_an_mp4_has_a_frame_per_state_and_rests_on_the_last(tmp_path: Path):
    save_mp4(walk(), tmp_path / "walk.mp4", milliseconds=200)
    frames = read_mp4(tmp_path / "walk.mp4", 6 * 32, 4 * 32)
    assert len(frames) == 4 + 5
    for picture, state in zip(frames, [*walk(), *walk()[-1:] * 5], strict=True):
        error = np.abs(picture.astype(int) - frame(state))
        assert error.mean() < 3
        assert np.quantile(error, 0.99) < 40  # edges of colours are soft: 4:2:0
    assert ", 5 fps" in told_of(tmp_path / "walk.mp4")


def test_a_video_plays_in_browsers(tmp_path: Path):
    save_mp4(walk(), tmp_path / "walk.mp4")
    reported = told_of(tmp_path / "walk.mp4")
    assert "Video: h264" in reported
    assert "yuv420p(tv, bt709" in reported
    video = (tmp_path / "walk.mp4").read_bytes()
    assert video.index(b"moov") < video.index(b"mdat")  # starts before all of it has come


def test_colours_of_a_video_are_those_of_its_frames(tmp_path: Path):
    colours = [(0, 114, 178), (213, 94, 0), (240, 194, 75), (255, 255, 255), (0, 0, 0)]
    pictures = [np.full((32, 48, 3), colour, np.uint8) for colour in colours]
    save_video(pictures, tmp_path / "colours.mp4")
    for picture, colour in zip(read_mp4(tmp_path / "colours.mp4", 48, 32), colours, strict=False):
        assert np.abs(picture.astype(int) - colour).max() <= 4


def test_an_odd_size_is_made_even_by_repeating_the_edge(tmp_path: Path):
    states = [World.parse("A.CG.", "line"), World.parse(".ACG.", "line")]
    save_mp4(states, tmp_path / "odd.mp4", cell=33)
    frames = read_mp4(tmp_path / "odd.mp4", 166, 34)
    error = np.abs(frames[0, :33, :165].astype(int) - frame(states[0], 33))
    assert error.mean() < 5
    edge = frames[0].astype(int)
    assert np.abs(edge[:, 165] - edge[:, 164]).max() < 30
    assert np.abs(edge[33] - edge[32]).max() < 30


def test_the_suffix_says_which_video(tmp_path: Path):
    for name in ("video.gif", "video.MP4"):
        hb.save_video(walk(), tmp_path / name, cell=16)
    assert (tmp_path / "video.gif").read_bytes().startswith(b"GIF89a")
    assert (tmp_path / "video.MP4").read_bytes()[4:8] == b"ftyp"


@pytest.mark.parametrize("name", ["pictures.gif", "pictures.mp4"])
def test_pictures_make_the_video_that_their_states_make(name: str, tmp_path: Path):
    save_video(walk(), tmp_path / name)
    of_states = (tmp_path / name).read_bytes()
    save_video(np.stack([frame(state) for state in walk()]), tmp_path / name)
    assert (tmp_path / name).read_bytes() == of_states


@pytest.mark.parametrize("suffix", ["gif", "mp4"])
@pytest.mark.ill_typed
def test_a_video_that_cannot_be_made_is_refused_and_nothing_written(suffix: str, tmp_path: Path):
    path = tmp_path / f"walk.{suffix}"
    picture = np.zeros((8, 8, 3), np.uint8)
    for states, says in (
        ([], "no states"),
        ([*walk(), ROOM], "state 4 is of another world"),
        ([picture, picture[:4]], r"picture 1 has shape \(4, 8, 3\)"),
        ([picture / 255], "picture 0 .* float64; give uint8"),
        ([picture[..., :1]], r"\(8, 8, 1\)"),
    ):
        with pytest.raises(ValueError, match=says):
            save_video(states, path)
    with pytest.raises(ValueError, match="milliseconds is 0"):
        save_video(walk(), path, milliseconds=0)
    assert not list(tmp_path.iterdir())


def test_a_video_with_another_suffix_is_refused(tmp_path: Path):
    with pytest.raises(ValueError, match=r"'\.png'.*\.gif"):
        save_gif([ROOM], tmp_path / "walk.png")
    with pytest.raises(ValueError, match=r"'\.gif'.*\.mp4"):
        save_mp4([ROOM], tmp_path / "walk.gif")
    with pytest.raises(ValueError, match=r"'\.avi'.*\.gif, \.mp4"):
        save_video([ROOM], tmp_path / "walk.avi")
    assert not list(tmp_path.iterdir())


def test_a_place_that_cannot_be_written_is_an_os_error(tmp_path: Path):
    for name in ("walk.gif", "walk.mp4"):
        with pytest.raises(FileNotFoundError):
            save_video(walk(), tmp_path / "nowhere" / name)


def test_a_video_says_which_extra_it_needs(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setitem(sys.modules, "imageio_ffmpeg", None)
    with pytest.raises(MissingExtraError, match=r"habilis\[video\]"):
        save_mp4(walk(), tmp_path / "walk.mp4")
    assert not list(tmp_path.iterdir())


def test_ffmpegs_complaint_is_passed_on(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr("habilis.worlds.pictures.video._COLOURS", "sepia")
    with pytest.raises(OSError, match=r"ffmpeg: .*sepia"):
        save_mp4(walk(), tmp_path / "walk.mp4")
    assert not list(tmp_path.iterdir())


def test_a_colour_that_only_a_picture_in_the_middle_has_is_kept(tmp_path: Path):
    pictures = np.zeros((3, 4, 6, 3), np.uint8)
    pictures[1] = (255, 10, 20)
    save_gif(pictures, tmp_path / "flash.gif")
    seen = [image.convert("RGB").getpixel((0, 0)) for image in frames_of(tmp_path / "flash.gif")]
    assert seen == [(0, 0, 0), (255, 10, 20), (0, 0, 0)]


@pytest.mark.parametrize("suffix", [".gif", ".mp4"])
@pytest.mark.parametrize(
    "numbers", [{"milliseconds": 250.5}, {"milliseconds": float("nan")}, {"cell": 0}, {"cell": 1.5}]
)
@pytest.mark.ill_typed
def test_numbers_that_are_no_whole_ones_are_refused(suffix, numbers, tmp_path: Path):
    path = tmp_path / f"walk{suffix}"
    (name,) = numbers
    with pytest.raises(ValueError, match=f"{name} is .*; give a whole number of at least 1"):
        save_video(walk(), path, **numbers)
    assert not path.exists()


@pytest.mark.parametrize("milliseconds", [5, 200_000])
def test_times_that_a_gif_cannot_say_are_refused(milliseconds, tmp_path: Path):
    with pytest.raises(ValueError, match=f"milliseconds is {milliseconds}; a GIF takes 10 to"):
        save_video(walk(), tmp_path / "walk.gif", milliseconds=milliseconds)
    assert not any(tmp_path.iterdir())
