"""Arrays in one .npz whose bytes have a checksum, so that a damaged file is never read.

The SHA-256 of all bytes follows them, for the checksums of the format do not cover all of a file.
NumPy reads it as it is. Arrays are not compressed, and begin at multiples of 64 bytes, so that they
can be mapped into memory.
"""

import hashlib
import os
import struct
import zipfile
from collections.abc import Mapping
from io import BytesIO
from pathlib import Path
from typing import BinaryIO

import numpy as np

Arrays = Mapping[str, np.ndarray]

MAPPED = 1 << 20
"""Bytes from which on an array is mapped, where that is asked for."""

_DIGEST = hashlib.sha256
_BLOCK = 1 << 20  # bytes read at once
_ALIGNED = 64  # bytes
_HEADER = 30  # bytes of a member's header, without its name and extra fields
_SIZES = 20  # bytes of the extra field for sizes above 4 GiB, which every member has
_PADDING = 0xD935  # the extra field that other programs pad with


class ChecksumError(ValueError):
    """The bytes of a file are not those that were written."""


def write_arrays(file: BytesIO, arrays: Arrays) -> None:
    """Writes arrays, and the checksum, to a binary file in memory."""
    with zipfile.ZipFile(file, "w", zipfile.ZIP_STORED) as saved:
        for name, array in arrays.items():
            member = zipfile.ZipInfo(f"{name}.npy")
            begins = file.tell() + _HEADER + len(member.filename.encode()) + _SIZES + 4
            room = -begins % _ALIGNED
            member.extra = struct.pack("<HH", _PADDING, room) + bytes(room)
            with saved.open(member, "w", force_zip64=True) as into:
                np.lib.format.write_array(into, np.asanyarray(array), allow_pickle=False)
    file.write(_DIGEST(file.getbuffer()).digest())


def read_arrays(path: Path, mapped: bool = False) -> dict[str, np.ndarray]:
    """The arrays of a file that `write_arrays` filled.

    The whole file is read once, in pieces, to check it.

    Args:
        path: of the file.
        mapped: whether arrays from `MAPPED` bytes up stay in the file, copied on write: they are
            read when they are used, processes share what they read, and what is written into them
            does not reach the file.

    Raises:
        ChecksumError: the checksum does not match.
        OSError: the file cannot be read.
    """
    with path.open("rb") as file:
        _check(file)
        found: dict[str, np.ndarray] = {}
        with zipfile.ZipFile(file) as saved, np.load(file, allow_pickle=False) as loaded:
            for member in saved.infolist():
                name = member.filename.removesuffix(".npy")
                array = _mapped(file, member) if mapped else None
                found[name] = loaded[name] if array is None else array
    return found


def _check(file: BinaryIO) -> None:
    digest, size = _DIGEST(), _DIGEST().digest_size
    left = os.fstat(file.fileno()).st_size - size
    block = memoryview(bytearray(_BLOCK))
    while left > 0 and (count := file.readinto(block[: min(left, _BLOCK)])):  # pyright: ignore[reportAttributeAccessIssue]
        digest.update(block[:count])
        left -= count
    if left != 0 or file.read() != digest.digest():
        raise ChecksumError("its checksum does not match")


def _mapped(file: BinaryIO, member: zipfile.ZipInfo) -> np.ndarray | None:
    """An array in the file; `None` of one that is small, or cannot be used where it lies."""
    if member.file_size < MAPPED or member.compress_type != zipfile.ZIP_STORED:
        return None
    file.seek(member.header_offset)
    header = file.read(_HEADER)
    name, extra = struct.unpack("<HH", header[-4:])
    file.seek(name + extra, os.SEEK_CUR)
    version = np.lib.format.read_magic(file)
    if version != (1, 0):
        return None
    shape, by_column, dtype = np.lib.format.read_array_header_1_0(file)
    aligned = file.tell() % max(dtype.alignment, 1) == 0  # not in files of earlier versions
    if dtype.hasobject or 0 in shape or not aligned:
        return None
    order = "F" if by_column else "C"
    return np.asarray(np.memmap(file, dtype, "c", file.tell(), shape, order))
