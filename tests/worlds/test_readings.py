"""Other readings of rules 3 to 5, as pictures before and after, in full, and in map text.

A word above the map chooses one, as in `P = picker pushes`; without it rules are as in
`test_rules.py`. The goal is kept out of the way.
"""

import math
from dataclasses import fields, replace
from functools import cache

import numpy as np
import pytest
from before_after import STEPS, becomes, cell_of, stays
from hypothesis import given, settings
from hypothesis import strategies as st
from rooms import rooms, sizes

from habilis.analysis.averages import average_empowerment
from habilis.analysis.pairs import pairs
from habilis.studio.drawn_worlds import drawn_of
from habilis.worlds.table import tabulate
from habilis.worlds.tools import Reading
from habilis.worlds.world import Cell, World, load_world

PUSHES, SHOVES, SWEEPS, STICKY = (
    f"P = picker {word}" for word in ("pushes", "shoves", "sweeps", "sticky")
)

# Rule 3: pushes


MOVED_INTO = """
    .AP..   .....
    ..C..   .AP..
    .....   ..C..
    G....   G....
    """


def test_a_picker_that_pushes_pushes_a_can_that_it_does_not_hold():
    becomes(MOVED_INTO, "south", above=PUSHES)


def test_a_picker_is_blocked_by_it_otherwise():
    before = "\n".join(line.split()[0] for line in MOVED_INTO.split("\n") if line.strip())
    for above in ("P = picker", SHOVES, SWEEPS):
        stays(before, "south", above=above)


def test_a_can_that_cannot_be_pushed_blocks_a_picker_that_pushes():
    stays(
        """
        .AP..
        ..C..
        ..#..
        G....
        """,
        "south",
        above=PUSHES,
    )


def test_a_picker_that_pushes_still_carries_what_it_holds():
    becomes(
        """
        .APC.   .....
        .....   .APC.
        G....   G....
        """,
        "south",
        above=PUSHES,
    )
    becomes(
        """
        .APC..   APC...
        G.....   G.....
        """,
        "west",
        above=PUSHES,
    )


def test_a_picker_that_pushes_is_blocked_when_it_is_put_onto_a_can():
    stays(
        """
        .P...
        .AC..
        G....
        """,
        "tool east",
        above=PUSHES,
    )


# Rule 5: shoves


def test_a_picker_that_shoves_pushes_a_can_away_when_it_is_put_there_and_then_holds_it():
    becomes(
        """
        .P...   .....
        .AC..   .APC.
        G....   G....
        """,
        "tool east",
        above=SHOVES,
    )


def test_a_can_against_a_wall_is_not_shoved():
    stays(
        """
        .P...
        .AC#.
        G....
        """,
        "tool east",
        above=SHOVES,
    )


def test_a_broom_that_shoves_does_so_too():
    becomes(
        """
        .B...   .....
        .AC..   .ABC.
        G....   G....
        """,
        "tool east",
        above="B = broom shoves",
    )


# Rule 5: sweeps


def test_a_swing_that_sweeps_needs_the_corner_free():
    picture = """
        .P#..
        .A...
        .....
        C...G
        """
    stays(picture, "tool east", above=SWEEPS)
    stays(picture.replace("P", "B"), "tool east", above="B = broom sweeps")
    becomes(
        """
        .P#..   ..#..
        .A...   .AP..
        .....   .....
        C...G   C...G
        """,
        "tool east",
        above="P = picker",
    )


@pytest.mark.parametrize("wall", [(0, 2), (1, 3), (1, 2)])
def test_a_held_can_is_swept_too(wall):
    rows = [".C...", ".P...", ".A...", ".....", "....G"]
    row, column = wall
    walled = [list(line) for line in rows]
    walled[row][column] = "#"
    stays("\n".join("".join(line) for line in walled), "tool east", above=SWEEPS)


def test_the_outer_corner_is_not_on_a_held_cans_way():
    becomes(
        """
        .C.#.   ...#.
        .P...   .....
        .A...   .APC.
        ....G   ....G
        """,
        "tool east",
        above=SWEEPS,
    )


def test_a_tool_comes_to_the_opposite_side_by_the_free_way():
    becomes(
        """
        .....   .....
        #P...   #....
        .A...   .A...
        .....   .P...
        C...G   C...G
        """,
        "tool south",
        above=SWEEPS,
    )
    stays(
        """
        .....
        #P...
        .A#..
        .....
        C...G
        """,
        "tool south",
        above=SWEEPS,
    )


def test_cans_are_not_swept_on_the_way():
    becomes(
        """
        .PC..   ..C..
        .A...   .AP..
        G....   G....
        """,
        "tool east",
        above=SWEEPS,
    )


# Rule 4: sticky


def test_a_sticky_picker_carries_a_can_beside_it():
    becomes(
        """
        ..C..   .....
        .AP..   ..C..
        .....   .AP..
        G....   G....
        """,
        "south",
        above=STICKY,
    )
    becomes(
        """
        ..C..   ..C..
        .AP..   .AP..
        .....   .....
        G....   G....
        """,
        *("east", "west"),
        above=STICKY,
    )


def test_a_can_beside_a_sticky_picker_turns_with_it():
    becomes(
        """
        ..C..   .....
        .AP..   .A...
        .....   .PC..
        G....   G....
        """,
        "tool south",
        above=STICKY,
    )
    becomes(
        """
        ..C..   .....
        .AP..   PA...
        .....   C....
        ....G   ....G
        """,
        "tool west",
        above=STICKY,
    )


def test_a_broom_holds_nothing_however_sticky():
    becomes(
        """
        ..C..   ..C..
        .AB..   .....
        .....   .AB..
        G....   G....
        """,
        "south",
        above="B = broom sticky",
    )


def test_a_sticky_pickers_can_is_attached():
    world = World.parse("P = picker sticky\n..C..\n.AP..\n.....\nG....")
    assert tabulate(world).flags["attached"][tabulate(world).start]
    plain = World.parse("..C..\n.AP..\n.....\nG....")
    assert not tabulate(plain).flags["attached"][tabulate(plain).start]


# All of it: against the rules written once more, slowly, one placement at a time


@cache
def crossed_by(off: Cell, turn: int) -> frozenset[Cell]:
    """The squares that a point at `off` from the agent crosses, in small steps."""
    found = set()
    for step in range(201):
        angle = math.radians(90 * turn * step / 200)
        row = off[0] * math.cos(angle) + off[1] * math.sin(angle)
        column = off[1] * math.cos(angle) - off[0] * math.sin(angle)
        found.add((round(row), round(column)))
    return frozenset(found)


def by_the_rules(world: World, at: dict[str, Cell], action: int) -> dict[str, Cell]:
    """The placement after an action, word by word."""
    reading, down, right = world.tools[0].reading, *STEPS[action % 4]
    agent, can, tool = at["agent"], at["object"], at["tool"]

    def plus(one: Cell, other: Cell, times: int = 1) -> Cell:
        return one[0] + times * other[0], one[1] + times * other[1]

    def is_bad(cell: Cell) -> bool:
        inside = 0 <= cell[0] < world.height and 0 <= cell[1] < world.width
        return not inside or cell in world.walls

    step, after = (down, right), dict(at)
    arm, off = plus(tool, agent, -1), plus(can, agent, -1)
    held = abs(arm[0]) + abs(arm[1]) == 1
    attached = False
    if held and world.tool == "picker":
        beside = abs(tool[0] - can[0]) + abs(tool[1] - can[1]) == 1
        attached = off == plus(arm, arm) or (reading.sticky and beside)
    if not held:
        if action >= 4:
            return at
        after["agent"] = plus(agent, step)
    elif action < 4:
        after["agent"], after["tool"] = plus(agent, step), plus(tool, step)
        pushes = world.tool == "broom" or reading.pushes
        if attached or (pushes and after["tool"] == can):
            after["object"] = plus(can, step)
    else:
        after["tool"] = plus(agent, step)
        turn = next(t for t in (0, 1, -1, 2) if turned(arm, t) == step)
        if attached:
            after["object"] = plus(agent, turned(off, turn))
        elif reading.shoves and after["tool"] == can:
            after["object"] = plus(can, step)
        if reading.sweeps:
            ways = []
            for way in (2, -2) if turn == 2 else (turn,):
                crossed = crossed_by(arm, way)
                crossed |= crossed_by(off, way) if attached else set()
                ways.append(any(is_bad(plus(agent, cell)) for cell in crossed))
            if all(ways):
                return at
    if action < 4 and after["agent"] == can:
        after["object"] = plus(can, step)
    if any(map(is_bad, after.values())) or len(set(after.values())) < 3:
        return at
    return after


def turned(off: Cell, quarters: int) -> Cell:
    for _ in range(quarters % 4):
        off = off[1], -off[0]
    return off


WORLDS = rooms(
    sizes(range(3, 6), range(3, 6)),
    lambda cells: cells // 3,
    ("picker", "broom"),
    st.builds(Reading, **{one.name: st.booleans() for one in fields(Reading)}),
)


@settings(max_examples=60, deadline=None)
@given(WORLDS)
def test_every_action_is_as_read(world: World):
    mdp = tabulate(world)
    for state in range(0, mdp.states, 3):
        at = {name: cell_of(mdp, name, state) for name in mdp.factors}
        for action in range(8):
            to = int(mdp.next_state[state, action])
            found = {name: cell_of(mdp, name, to) for name in mdp.factors}
            assert found == by_the_rules(world, at, action), (at, action, world.text())


@settings(max_examples=30, deadline=None)
@given(WORLDS)
def test_what_is_attached_stays_so_under_every_reading(world: World):
    mdp = tabulate(world)
    attached = mdp.flags["attached"]
    assert attached[mdp.next_state[attached]].all()


# Map text, other tools in its place, and the rest of the engine


@settings(max_examples=30, deadline=None)
@given(WORLDS)
def test_a_reading_is_written_above_the_map_and_read_back(world: World):
    assert World.parse(world.text(), "random") == world


def test_words_come_in_any_order_and_with_a_slip():
    world = World.parse("X = picker sweeps pushes slip 0.5\nAX.CG")
    assert (world.tools[0].kind, world.tools[0].slip) == ("picker", 0.5)
    assert world.tools[0].reading == Reading(pushes=True, sweeps=True)
    assert world.text().startswith("P = picker pushes sweeps slip 0.5\n")
    with pytest.raises(
        ValueError, match="line 1: 'P' is bound to 'picker pulls', which is unknown"
    ):
        World.parse("P = picker pulls\nAP.CG")


def test_another_tool_in_its_place_is_read_alike():
    world = World.parse("P = picker pushes shoves\nAP.CG")
    assert world.with_tool("broom").tools[0].reading == world.tools[0].reading
    assert world.with_tool("none").with_tool("picker") == world
    several = World.parse("P = picker pushes\nAP.CG\n.B...")
    assert [tool.reading.words for tool in several.tools] == ["pushes", ""]
    assert several.with_tool("broom").tools[0].reading == Reading()
    assert several.with_tool(several.tools[0]).tools[0].reading == Reading(pushes=True)


def read(world: World, reading: Reading) -> World:
    """A world with its tool's rules read in this way."""
    return world.with_tool(replace(world.tools[0], reading=reading))


def test_our_reading_changes_no_map_and_no_table():
    world = load_world("yard")
    assert world.tools[0].reading == Reading()
    assert World.parse("P = picker\n" + world.text(), "yard") == world
    pushing = read(world, Reading(pushes=True))
    assert not np.array_equal(tabulate(pushing).next_state, tabulate(world).next_state)
    broom = world.with_tool("broom")
    swept = read(broom, Reading(pushes=True, sticky=True))
    assert np.array_equal(tabulate(swept).next_state, tabulate(broom).next_state)


def test_two_pickers_read_otherwise_are_two_tools_to_compare():
    world = World.parse("P = picker pushes\nQ = picker\n......\n.APC..\n......\nG....Q")
    averages = pairs(world, 2).averages[-1, :, 0]
    alone = [average_empowerment(tabulate(world.with_tool(one)), 2) for one in world.tools]
    assert averages[:2] == pytest.approx(alone)
    assert averages[0] > averages[1]


def test_the_page_refuses_what_it_does_not_draw_in_one_line():
    world = World.parse("P = picker pushes\nAP.CG")
    with pytest.raises(ValueError, match="'pushes'") as refusal:
        drawn_of(world)
    assert "\n" not in str(refusal.value)
