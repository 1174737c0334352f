"""Reading videos back."""

import subprocess
from pathlib import Path

import imageio_ffmpeg
import numpy as np


def read_mp4(path: Path, width: int, height: int) -> np.ndarray:
    """The pictures of a video: uint8[frames, height, width, 3]."""
    command = [imageio_ffmpeg.get_ffmpeg_exe(), "-loglevel", "error", "-i", path]
    command += ["-f", "rawvideo", "-pix_fmt", "rgb24", "-"]
    pixels = subprocess.run(command, capture_output=True, check=True).stdout
    return np.frombuffer(pixels, np.uint8).reshape(-1, height, width, 3)
