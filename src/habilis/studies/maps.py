"""The reconstructed maps: those that `habilis reconstruct` found besides the built-in worlds."""

from pathlib import Path

MAPS = Path(__file__).parent / "data" / "maps"


def map_names(experiment: str) -> list[str]:
    """The names of the maps that were found for an experiment, in order.

    Args:
        experiment: "corridor" or "yard".

    Example:
        >>> map_names("yard")[0]
        'yard-01'
    """
    return sorted(path.stem for path in MAPS.glob(f"{experiment}-*.txt"))


def world_source(name: str) -> str:
    """The argument of `load_world` for a map: the path of a reconstruction, or a built-in name."""
    path = MAPS / f"{name}.txt"
    return str(path) if path.is_file() else name
