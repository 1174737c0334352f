"""The characters of a map that do not stand for a tool."""

WALL, FLOOR, AGENT, OBJECT, GOAL = "#.ACG"
TOOL = "tool"
"""Stands beside these for what a tool's character means: every tool has its own."""
COMMENT = ";"
BINDS = "="
"""Between a character and what it stands for, in a line above the map."""

_TAKEN = {
    WALL: "a wall",
    FLOOR: "floor",
    AGENT: "the agent",
    OBJECT: "the can",
    GOAL: "the goal",
    COMMENT: "a comment",
    BINDS: "what binds a character",
}


def check_free(character: object, but: str = "") -> None:
    """Refuses what cannot stand for a tool, or something else of one's own, on a map.

    Args:
        character: what is to stand for it.
        but: a character that may, though a map has another use for it.

    Raises:
        ValueError: it is not one printable character, or a map needs it for something else.
    """
    if not isinstance(character, str) or len(character) != 1 or not character.isprintable():
        raise ValueError(f"character is {character!r}; give one printable character, such as 'R'")
    if character.isspace() or (character in _TAKEN and character != but):
        meaning = _TAKEN.get(character, "nothing")
        raise ValueError(
            f"character {character!r} stands for {meaning} on a map; give another, such as 'R'"
        )
