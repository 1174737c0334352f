"""The states of a table as worlds or puzzles, for pictures."""

from habilis.mdp import TabularMDP
from habilis.reprs import svg_image
from habilis.worlds.pictures.figures import Drawn
from habilis.worlds.pictures.svg import world_svg
from habilis.worlds.table import placement
from habilis.worlds.world import World


def drawn_state(mdp: TabularMDP, state: int) -> World | Drawn | None:
    """A state of the table of a world or puzzle, as one of these; `None` of any other table."""
    if isinstance(mdp.drawn, World):
        return placement(mdp.drawn, mdp, state)
    if mdp.drawn is None or mdp.model_states is None:
        return None
    return mdp.drawn.at(mdp.state(state))


def start_image(mdp: TabularMDP) -> str | None:
    """The start of a table as an image of HTML; `None` where it cannot be drawn."""
    drawn = drawn_state(mdp, mdp.start)
    if drawn is None:
        return None
    svg = world_svg(drawn, cell=16, across=240)
    return None if svg is None else svg_image(svg, f"the start in {drawn.name}")
