"""Files that are written whole or not at all, and places that are checked before any work."""

import os
import stat
import tempfile
from collections.abc import Callable, Collection, Iterable, Iterator
from contextlib import contextmanager, suppress
from io import BytesIO
from pathlib import Path
from secrets import token_hex

PICTURES = (".png", ".svg", ".pdf")
TABLES = (".csv", ".parquet", ".npz", ".npy")
VIDEOS = (".gif", ".mp4")
FOLDER = ()
"""In place of suffixes: a folder is written."""

_LONGEST_NAME = 240  # bytes: what file systems allow, less what a temporary name adds
_PARTIAL = ".partial"
_SHOWN = 200  # characters of a path in a message


def suffix_of(path: str | Path, known: Iterable[str]) -> str:
    """The suffix of a file's name, in lower case.

    Raises:
        ValueError: it is none of the known ones; the message lists them.

    Example:
        >>> suffix_of("Bits.CSV", [".csv", ".parquet"])
        '.csv'
    """
    suffix = Path(path).suffix.lower()
    if suffix not in known:
        raise ValueError(
            f"{path}: unknown suffix {suffix!r}; let the name end with {', '.join(known)}"
        )
    return suffix


def shown(name: object) -> str:
    """A name for a message: in one line, and not longer than one reads.

    Example:
        >>> shown("room.txt"), len(shown("rooms/" * 100))
        ('room.txt', 203)
    """
    text = str(name) if str(name).isprintable() else repr(str(name))
    return text if len(text) <= _SHOWN else f"{text[:_SHOWN]}..."


def text_of(path: str | Path, what: str) -> str:
    """The text of a file.

    Args:
        path: of the file.
        what: what is in it, for messages: "a PushWorld puzzle".

    Raises:
        ValueError: it cannot be read, or is no text.
    """
    if not isinstance(path, str | Path):
        raise ValueError(f"path is {shown(repr(path))}; give the path of a file with {what}")
    try:
        if Path(path).exists() and not Path(path).is_file():
            raise IsADirectoryError(0, "it is not a file")
        return Path(path).read_text("utf-8")
    except UnicodeDecodeError:
        raise ValueError(f"{shown(path)}: not a text file; give one with {what}") from None
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or error
        named = shown(path) if str(path) else "''"
        raise ValueError(
            f"{named}: cannot be read ({reason}); give the path of a file with {what}"
        ) from None


def write_whole(path: str | Path, write: Callable[[BytesIO], object]) -> None:
    """Writes a file whole or not at all: in memory, beside its place, onto the disk, then renamed.

    Until everything is on the disk, an earlier file is as it was; it keeps its permissions. A
    symbolic link stays one, and its target is replaced. What is no regular file (a pipe, a
    terminal) cannot be renamed to: it gets everything at once, after `write` has succeeded.

    Args:
        path: where the file goes.
        write: what fills a binary file. It is given one in memory: libraries hide a full disk
            behind errors of their own (Matplotlib's of a .pdf is a zlib.error).

    Raises:
        OSError: the file cannot be written; an earlier one is untouched and nothing is left behind.
    """
    target = _target(path)
    earlier = _status(target)
    regular = earlier is None or stat.S_ISREG(earlier.st_mode)
    if earlier is not None and regular and not os.access(target, os.W_OK):
        raise PermissionError(13, "the file there is read-only", str(target))
    content = BytesIO()
    write(content)
    if not regular:
        with target.open("wb") as file:
            file.write(content.getbuffer())
        return
    # Under a name of its own: other processes may write the same file.
    temporary = target.with_name(f".{_cut(target.name)}.{token_hex(4)}{_PARTIAL}")
    try:
        with temporary.open("xb") as file:
            file.write(content.getbuffer())
            file.flush()
            _keep_permissions(earlier, temporary)
            os.fsync(file.fileno())
        temporary.replace(target)
    except BaseException:
        temporary.unlink(missing_ok=True)
        raise
    with suppress(OSError):  # not every system can; the file is there, and whole
        _sync_folder(target.parent)


def save_whole(path: str | Path, write: Callable[[BytesIO], object]) -> None:
    """`write_whole` for those who name the file.

    Raises:
        ValueError: the file cannot be written; says why.
    """
    with writing(path):
        write_whole(path, write)


@contextmanager
def writing(
    path: str | Path, fix: str = "make room there, or name another place"
) -> Iterator[None]:
    """Turns an OSError of a file or folder into one line.

    Args:
        path: named in the line.
        fix: the end of the line.

    Raises:
        ValueError: an OSError was raised; the message has the path, the reason and the fix.
    """
    try:
        yield
    except OSError as error:
        reason = error.strerror or error
        raise ValueError(f"{path}: cannot be written ({reason}); {fix}") from error


def is_partial(name: str, of: str) -> bool:
    """Whether a name is what a file is called while it is written."""
    return name.startswith(f".{_cut(of)}.") and name.endswith(_PARTIAL)


def remove_partial(folder: Path) -> None:
    """Removes the partial files of killed processes from a folder without other writers."""
    for path in folder.rglob(f".*{_PARTIAL}"):
        path.unlink(missing_ok=True)


def check_file(path: str | Path, known: Iterable[str]) -> None:
    """Refuses a file that could not be written, before what is to be in it is computed.

    Leaves nothing behind.

    Args:
        path: where it is to go.
        known: the suffixes that its name may have.

    Raises:
        ValueError: another suffix, no such folder, something else in the file's place, or no
            permission; says how to fix it.
    """
    suffix_of(path, known)
    check_path(path)
    with writing(path):
        target = _target(path)
        there, folder = _status(target), target.parent
        if there is not None and stat.S_ISDIR(there.st_mode):
            raise ValueError(f"{path}: cannot be written (it is a folder); name a file in it")
        if not folder.exists():
            missing = folder if Path(path).is_symlink() else Path(path).parent
            raise ValueError(
                f"{path}: cannot be written (there is no folder {missing}); make it first"
            )
        if not folder.is_dir():
            raise ValueError(
                f"{path}: cannot be written ({folder} is not a folder); name another place"
            )
        if there is not None and not os.access(target, os.W_OK):
            raise ValueError(f"{path}: cannot be written (it is read-only); name another file")
        if there is None or stat.S_ISREG(there.st_mode):
            _check_room(path, folder)


def check_folder(folder: str | Path) -> None:
    """Refuses a folder that cannot be made or written, before any work is done.

    Leaves nothing behind; a folder that is not there yet is not made.

    Raises:
        ValueError: what exists of its path is no folder, or cannot be written to.
    """
    folder = Path(folder)
    path = folder.absolute()
    if max(len(os.fsencode(part)) for part in path.parts) > _LONGEST_NAME:
        raise ValueError(f"{shown(folder)}: the name is too long; give a shorter one")
    check_path(folder)
    existing = next(p for p in (path, *path.parents) if os.path.lexists(p))
    if not existing.is_dir():
        raise ValueError(f"{folder}: {existing} is not a folder; name another place")
    _check_room(folder, existing)


def check_unused(folder: str | Path, but: Collection[str] = ()) -> None:
    """Refuses a folder in which something could be overwritten, before any work is done.

    Args:
        folder: new or empty.
        but: names of files that may be there, whole or half written.

    Raises:
        ValueError: it exists and is not an empty folder, or cannot be written.
    """
    folder = Path(folder)
    check_folder(folder)
    names = [path.name for path in folder.iterdir()] if folder.exists() else []
    if any(name not in but and not any(is_partial(name, of) for of in but) for name in names):
        raise ValueError(
            f"{folder}: exists already; name a new folder, or remove it "
            "(--resume continues what was interrupted there)"
        )


def check_path(path: str | Path) -> None:
    """Refuses what no system takes for a path.

    Raises:
        ValueError: it is too long, has a character that no path has, or leads where one may not
            look.
    """
    try:
        os.lstat(path)
    except (FileNotFoundError, NotADirectoryError):
        pass
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or error
        raise ValueError(
            f"{shown(path)}: is not a valid path ({reason}); name another place"
        ) from None


def _check_room(path: str | Path, folder: Path) -> None:
    """Makes a file without a name: permissions alone do not say what a file system allows."""
    try:
        with tempfile.TemporaryFile(dir=folder):
            pass
    except OSError as error:
        raise ValueError(
            f"{path}: {folder} cannot be written to ({error.strerror or error}); name another place"
        ) from None


def _target(path: str | Path) -> Path:
    """The file itself, where a symbolic link is named."""
    return Path(os.path.realpath(path))


def _status(path: Path) -> os.stat_result | None:
    """The status of a path, if it exists."""
    try:
        return path.stat()
    except (FileNotFoundError, NotADirectoryError):
        return None


def _keep_permissions(earlier: os.stat_result | None, path: Path) -> None:
    """Gives a file the owner and the permissions of the earlier one in its place."""
    if earlier is None:
        return
    if hasattr(os, "chown"):
        with suppress(OSError):  # only root may give files away
            os.chown(path, earlier.st_uid, earlier.st_gid)
    path.chmod(stat.S_IMODE(earlier.st_mode))


def _cut(name: str) -> str:
    """As much of a name as leaves room for what a temporary name adds."""
    return os.fsencode(name)[: _LONGEST_NAME - 16].decode(errors="ignore")


def _sync_folder(folder: Path) -> None:
    handle = os.open(folder, os.O_RDONLY)
    try:
        os.fsync(handle)
    finally:
        os.close(handle)
