"""The window of render_mode="human", on a screen of its own."""

import os
import shutil
import subprocess
import sys

import numpy as np
import pytest

import habilis as hb
from habilis.worlds.pictures.figures import frame
from habilis.worlds.table import placement

PLAY = """
import gymnasium, habilis, sys
env = gymnasium.make("habilis/Yard-v0", render_mode="human")
env.reset(seed=0)
for action in (1, 2):
    env.step(action)
print(env.unwrapped.state, flush=True)
sys.stdin.readline()
env.close()
"""


@pytest.fixture
def screen(tmp_path):
    """A screen without a monitor, whose picture is a file."""
    if shutil.which("Xvfb") is None:
        pytest.skip("Xvfb is not installed: apt-get install xvfb")
    size = ("-screen", "0", "800x600x24", "-fbdir", str(tmp_path))
    reading, writing = os.pipe()
    server = subprocess.Popen(
        ["Xvfb", "-displayfd", str(writing), *size], pass_fds=[writing], stderr=subprocess.DEVNULL
    )
    os.close(writing)
    with os.fdopen(reading) as reported:
        display = reported.readline().strip()
    yield f":{display}", tmp_path / "Xvfb_screen0"
    server.terminate()
    server.wait()


def seen(path):
    """The pixels of a screen, from the file (an X window dump) that Xvfb keeps."""
    content = path.read_bytes()
    header = np.frombuffer(content, ">u4", 25)
    size, width, height, row, colours = (int(header[at]) for at in (0, 4, 5, 12, 19))
    pixels = np.frombuffer(content, np.uint8, row * height, size + 12 * colours)
    return pixels.reshape(height, -1, 4)[:, :width, 2::-1]


def test_the_window_shows_the_picture_of_the_state(screen):
    display, framebuffer = screen
    environment = os.environ | {"DISPLAY": display, "SDL_VIDEODRIVER": "x11"}
    player = subprocess.Popen(
        [sys.executable, "-W", "error", "-c", PLAY],
        env=environment,
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
    )
    assert player.stdout is not None
    reported = [player.stdout.readline()]
    while reported[-1] and not reported[-1].strip().isdigit():  # pygame greets first
        reported.append(player.stdout.readline())
    mdp = hb.tabulate(hb.load_world("yard"))
    state = int(mdp.next_state[mdp.next_state[mdp.start, 1], 2])
    assert int(reported[-1]) == state
    picture = frame(placement(hb.load_world("yard"), mdp, state))
    shown = seen(framebuffer)
    windows = np.lib.stride_tricks.sliding_window_view(shown[:, :, 0], picture.shape[:2])
    corners = np.argwhere(windows[..., 5, 5] == picture[5, 5, 0])
    assert any(
        np.array_equal(shown[y : y + picture.shape[0], x : x + picture.shape[1]], picture)
        for y, x in corners
    )
    player.communicate("\n")
    assert player.returncode == 0
