"""What a file is to hold, by the end of its name."""

from collections.abc import Iterable
from pathlib import Path


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
