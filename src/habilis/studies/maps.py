"""The other maps that meet the paper's numbers, as `habilis reconstruct` found them."""

from importlib.resources import files

from habilis.worlds.world import World


def other_maps(experiment: str) -> list[World]:
    """The maps that were found for an experiment, besides the built-in one.

    Args:
        experiment: "corridor" or "yard".

    Returns:
        Worlds named "corridor-01" and so on, in order.

    Example:
        >>> other_maps("yard")[0].name
        'yard-01'
    """
    folder = files("habilis.studies") / "data" / "maps"
    found = sorted(file.name for file in folder.iterdir() if file.name.startswith(f"{experiment}-"))
    return [
        World.parse((folder / name).read_text("utf-8"), name.removesuffix(".txt")) for name in found
    ]
