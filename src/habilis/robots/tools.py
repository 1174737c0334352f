"""Which tools a MuJoCo model has, and the model with one of them in the hand.

A model has a body `hand`, a body `puck`, and geoms in the hand. A geom of the hand, or of a body
fixed to it, belongs to the tool that the first word of its name is: "hook" and "hook bar" are the
hook. Geoms without a name, and those whose name begins with "hand", are the hand's own.
"""

from collections.abc import Iterator
from pathlib import Path
from typing import Any

from habilis.estimators.simulators.mujoco import imported
from habilis.robots.reach import NAME, Reach
from habilis.worlds.world import NO_TOOL

HAND, PUCK = "hand", "puck"


def tools_of(model: str | Path) -> list[str]:
    """The tools of a model, in its order.

    Args:
        model: the path of an XML file, or its text; "reach.xml" is the built-in one where there
            is no such file.

    Returns:
        Names, without "none".

    Raises:
        ValueError: MuJoCo cannot read it, or it has no hand or no puck.
        MissingExtraError: MuJoCo is not installed.

    Example:
        >>> tools_of("reach.xml")
        ['stick', 'hook', 'scoop']
    """
    return _tools(_specification(model))


def with_tool(model: str | Path, tool: str) -> Any:
    """The model with one tool in the hand, all others left out.

    Args:
        model: as in `tools_of`.
        tool: one of its tools, or "none".

    Returns:
        A `mujoco.MjModel`.

    Raises:
        ValueError: no such tool, or as in `tools_of`.
    """
    specification = _specification(model)
    known = _tools(specification)
    if tool not in (*known, NO_TOOL):
        raise ValueError(
            f"{_shown(model)} has no tool {tool!r} in the hand; use one of "
            f"{', '.join([*known, NO_TOOL])}"
        )
    for geom in list(_geoms(specification.body(HAND))):
        owner = _owner(geom.name)
        if owner is not None and owner != tool:
            specification.delete(geom)
    try:
        return specification.compile()
    except ValueError as error:
        raise ValueError(f"{_shown(model)} with {tool}: {' '.join(str(error).split())}") from None


def _specification(model: str | Path) -> Any:
    mujoco = imported()
    text = str(model)
    if text == NAME and not Path(text).exists():
        text = Reach().xml()
    if not text.lstrip().startswith("<") and not Path(text).is_file():
        raise ValueError(
            f"{text}: no such file; give the path of a MuJoCo file, or {NAME}, which is built in"
        )
    try:
        if text.lstrip().startswith("<"):
            specification = mujoco.MjSpec.from_string(text)
        else:
            specification = mujoco.MjSpec.from_file(text)
    except ValueError as error:
        raise ValueError(
            f"MuJoCo cannot read {_shown(model)}: {' '.join(str(error).split())}"
        ) from None
    for name in (HAND, PUCK):
        if specification.body(name) is None:
            raise ValueError(f"{_shown(model)} has no body {name!r}; name one so")
    return specification


def _tools(specification: Any) -> list[str]:
    owners = (_owner(geom.name) for geom in _geoms(specification.body(HAND)))
    return list(dict.fromkeys(owner for owner in owners if owner is not None))


def _geoms(body: Any) -> Iterator[Any]:
    """The geoms of a body and of those fixed to it."""
    yield from body.geoms
    for inner in body.bodies:
        yield from _geoms(inner)


def _owner(name: str) -> str | None:
    """The tool that a geom belongs to; `None` of the hand itself."""
    word = name.split()[0] if name.split() else ""
    return None if not word or word.startswith(HAND) else word


def _shown(model: str | Path) -> str:
    text = str(model)
    return "the model" if text.lstrip().startswith("<") else text
