"""Arrays in one .npz whose bytes have a checksum, so that a damaged file is never read.

The SHA-256 of all bytes follows them, for the checksums of the format do not cover all of a file.
NumPy reads it as it is.
"""

import hashlib
from collections.abc import Mapping
from io import BytesIO
from pathlib import Path

import numpy as np

Arrays = Mapping[str, np.ndarray]

_DIGEST = hashlib.sha256


class ChecksumError(ValueError):
    """The bytes of a file are not those that were written."""


def write_arrays(file: BytesIO, arrays: Arrays) -> None:
    """Writes arrays, and the checksum, to a binary file in memory."""
    np.savez(file, allow_pickle=False, **arrays)
    file.write(_DIGEST(file.getbuffer()).digest())


def read_arrays(path: Path) -> dict[str, np.ndarray]:
    """The arrays of a file that `write_arrays` filled.

    Raises:
        ChecksumError: the checksum does not match.
        OSError: the file cannot be read.
    """
    content = path.read_bytes()
    size = _DIGEST().digest_size
    if _DIGEST(memoryview(content)[:-size]).digest() != content[-size:]:
        raise ChecksumError("its checksum does not match")
    with np.load(BytesIO(content), allow_pickle=False) as saved:
        return {name: saved[name] for name in saved.files}
