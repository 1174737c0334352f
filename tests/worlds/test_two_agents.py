"""Maps with two agents: their rule beside a slow one, their text, tables and pictures, refusals."""

from dataclasses import replace
from functools import cache
from itertools import product

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

import habilis as hb
from habilis.analysis import landscape, pairs, usefulness
from habilis.envs import WorldEnv
from habilis.studio.drawn_worlds import drawn_of
from habilis.worlds.pictures import Tiles
from habilis.worlds.pictures.figures import colored_text
from habilis.worlds.two_agents import TwoAgents, start_of

Cell = tuple[int, int]
WAYS = {"north": (-1, 0), "east": (0, 1), "south": (1, 0), "west": (0, -1)}
CORRIDOR = "E = agent\nA..E."
HOUSE = "E = agent\nD = door\nO = open door\nA.DE\n#OCG\n"


@cache
def house() -> hb.TabularMDP:
    return hb.tabulate(hb.World.parse(HOUSE))


@st.composite
def houses(draw: st.DrawFn) -> hb.World:
    """Small maps with two agents, up to two objects, doors and some walls."""
    height, width = draw(st.integers(2, 3)), draw(st.integers(3, 4))
    objects, doors = draw(st.integers(0, 2)), draw(st.integers(0, 2))
    cells = draw(st.permutations([(r, c) for r in range(height) for c in range(width)]))
    marks = "AE" + "CK"[:objects] + "DO"[:doors]
    things, others = cells[: len(marks)], cells[len(marks) :]
    rows = [["."] * width for _ in range(height)]
    for row, column in others[: draw(st.integers(0, len(others) // 2))]:
        rows[row][column] = "#"
    for mark, (row, column) in zip(marks, things, strict=True):
        rows[row][column] = mark
    kinds = {"E": "agent", "C": "can", "K": "crate", "D": "door", "O": "open door"}
    above = [f"{mark} = {kinds[mark]}" for mark in marks[1:]]
    return hb.World.parse("\n".join([*above, *("".join(row) for row in rows)]))


def acted(
    world: hb.World, agents: list[Cell], objects: list[Cell], doors: dict[Cell, bool], who, do
):
    """One agent's action, once more: slowly, in coordinates, changing what is given."""
    row, column = agents[who]
    if do == "door":
        for door in doors:
            beside = abs(door[0] - row) + abs(door[1] - column) == 1
            if beside and door not in agents + objects:
                doors[door] = not doors[door]
    if do not in WAYS:
        return

    def is_taken(cell: Cell) -> bool:
        closed = cell in doors and not doors[cell]
        return closed or not world.is_free(cell) or cell in agents or cell in objects

    step = WAYS[do]
    ahead = row + step[0], column + step[1]
    if ahead in objects:
        beyond = ahead[0] + step[0], ahead[1] + step[1]
        if is_taken(beyond):
            return
        objects[objects.index(ahead)] = beyond
    if not is_taken(ahead):
        agents[who] = ahead


def cells_of(world: hb.World) -> tuple[list[Cell], list[Cell], dict[Cell, bool]]:
    assert world.second is not None
    doors = {door.cell: door.is_open for door in world.doors}
    return [world.agent, world.second], [thing.cell for thing in world.objects], doors


@settings(deadline=None, max_examples=12)
@given(houses(), st.randoms(use_true_random=False))
def test_both_move_as_a_slow_rule_says(world: hb.World, random):
    model = TwoAgents(world)
    row = np.array([model.row(start_of(world))])
    agents, objects, doors = cells_of(world)
    for _ in range(40):
        joint = random.randrange(len(model.actions))
        for who, do in enumerate(model.actions[joint].split("+")):
            acted(world, agents, objects, doors, who, do)
        row = model.step_many(row, np.array([joint]))
        found = {
            name: tuple(np.ravel(one).tolist()) for name, one in model.factors_many(row).items()
        }
        assert [found[name] for name in ("agent", "agent2")] == agents
        assert [found[name] for name in model.things] == objects
        assert [found[name] for name in model.doors] == [(int(one),) for one in doors.values()]


@settings(deadline=None, max_examples=5)
@given(houses(), st.integers(0, 10_000))
def test_many_steps_at_once_are_the_same_one_by_one(world: hb.World, seed: int):
    rng, model = np.random.default_rng(seed), TwoAgents(world)
    rows = np.array([model.row(start_of(world))] * 10)
    for _ in range(3):
        joint = rng.integers(len(model.actions), size=len(rows))
        each = [model.step_many(row[None], joint[[n]])[0] for n, row in enumerate(rows)]
        rows = model.step_many(rows, joint)
        assert (rows == each).all()


@settings(deadline=None, max_examples=25)
@given(houses())
def test_a_map_is_written_and_read_back(world: hb.World):
    assert hb.World.parse(world.text(), "map") == world
    assert hb.World.parse(str(world)) == world


def test_the_table_of_a_map_has_players_and_a_factor_for_everything():
    mdp = house()
    assert mdp.players == {"agent": 6, "agent2": 6}
    assert mdp.action_count == 36
    assert mdp.actions[:2] == ("north+north", "north+east")
    assert list(mdp.factors) == ["agent", "agent2", "object", "door", "door2"]
    assert mdp.shape == (2, 4)
    assert mdp.start == mdp.find(
        **{"agent": (0, 0), "agent2": (0, 3), "object": (1, 2), "door": 0, "door2": 1}
    )
    alone = mdp.of_player("agent2")
    assert alone.actions == ("north", "east", "south", "west", "stay", "door")


def test_without_doors_there_is_no_action_for_them():
    mdp = hb.tabulate(hb.World.parse(CORRIDOR))
    assert mdp.players == {"agent": 5, "agent2": 5}
    assert mdp.states == 10  # the first never comes past the second
    assert not mdp.terminal.any()
    assert not mdp.reward.any()


def test_an_object_in_its_goal_ends_an_episode():
    world, mdp = hb.World.parse(HOUSE), house()
    plan = hb.solve(world)
    assert plan is not None
    assert [name.split("+")[0] for name in plan.action_names] == ["east", "south", "east"]
    assert plan.best_return == -2
    assert set(np.unique(mdp.reward)) == {-1, 0}


def test_of_several_objects_factors_have_their_names():
    mdp = hb.tabulate(hb.World.parse("E = agent\nK = crate\nA.C.\nE.K."))
    assert list(mdp.factors) == ["agent", "agent2", "object:can", "object:crate"]


def test_what_is_explored_around_placements_is_part_of_the_table():
    world = hb.World.parse(HOUSE)
    mdp, placement = house(), start_of(world) | {"agent": (0, 1), "door": 1}
    for others in ("uniform", "best"):
        whole = hb.empowerment(
            mdp, 2, "agent", states=[mdp.find(**placement)], player="agent", others=others
        )
        part = hb.empowerment(world, 2, "agent", states=[placement], player="agent", others=others)
        np.testing.assert_allclose(part, whole, atol=1e-6)
    assert hb.explore(world, [placement], horizon=1).states < mdp.states


def test_a_landscape_is_over_the_first_agents_cell():
    world = hb.World.parse("E = agent\n##.##\nE..A.", "corridor")
    mdp = hb.tabulate(world)
    for others in ("uniform", "best", "worst"):
        values = hb.empowerment(mdp, 2, "agent2", player="agent2", others=others)
        found = landscape(world, 2, "agent2", player="agent2", others=others)
        assert np.isnan(found.values[1, 0])
        for row, column in ((0, 2), (1, 1), (1, 4)):
            state = mdp.find(agent=(row, column), agent2=(1, 0))
            assert found.values[row, column] == pytest.approx(values[state], abs=1e-6)
    assert found.world == world
    assert found.title == "2-step empowerment of agent2, sensor 'agent2'"
    closed = landscape(mdp, 1, "agent2", player="agent2", kind="closed-loop")
    assert closed.values[1, 3] == pytest.approx(
        hb.empowerment(mdp, 1, "agent2", player="agent2", states=[mdp.start])[0], abs=1e-5
    )
    with pytest.raises(ValueError, match="kind 'closed-loop'; give the others a policy"):
        landscape(mdp, 1, player="agent2", others="best", kind="closed-loop")
    with pytest.raises(ValueError, match="is a map with two agents; leave out tool, object"):
        landscape(world, 1, object=(0, 2))


def test_noise_replaces_the_joint_action():
    world = hb.World.parse(CORRIDOR)
    assert hb.tabulate(world, slip=0.5).players == {"agent": 5, "agent2": 5}


def test_bindings_of_the_same_characters_keep_their_meaning():
    for kind, cells in (("rake", "A.E.CG"), ("crate", "A.E..G")):
        world = hb.World.parse(f"E = {kind}\n{cells}")
        assert world.second is None
        assert kind in (*(t.kind for t in world.tools), *(o.kind for o in world.objects))


def test_pictures_and_words_show_both_agents_and_the_doors():
    world = hb.World.parse(HOUSE)
    assert "second agent (0, 3)" in repr(world)
    assert "door (0, 2), open door (1, 1)" in repr(world)
    assert colored_text(world).plain == "A . D E \n# O C G "
    alone = hb.World.parse("A.C.G")
    assert len(world._repr_svg_() or "") > len(alone._repr_svg_() or "")
    inside = replace(world, agent=(1, 1))
    assert colored_text(inside).plain.splitlines()[1] == "# AOC G "
    with pytest.raises(ValueError, match=r"something else is in the door at \(1, 1\)"):
        inside.text()


# Refusals


@pytest.mark.parametrize(
    ("text", "problem"),
    [
        ("E = agent\nF = agent\nAEF", r"a third agent is at \(0, 2\)"),
        ("E = agent\nA.EP", "two agents has no tools; leave them out"),
        ("E = agent\nD = ball\nA.ED", "nothing slides, as the ball does; use a can or a crate"),
        ("D = door\nA.DCG", "doors are for two agents; bind a second, as 'E = agent'"),
        ("E = agent\n.E..", "the map has no agent; put one 'A'"),
        ("E = agent\nA...", "'E' is bound to 'agent' but is not on the map"),
        ("E = agent\nA.E.G", "'G' is a goal, but no object is on the map; add one, or put"),
        ("E = agents\nA.E", r"a second agent \(agent\) or a door \(door, open door\)"),
    ],
)
def test_a_map_that_is_none_is_refused(text: str, problem: str):
    with pytest.raises(ValueError, match=problem) as error:
        hb.World.parse(text)
    assert "\n" not in str(error.value)


@pytest.mark.parametrize(
    ("cells", "problem"),
    [
        ({"second": (0, 0)}, "share a cell"),
        ({"second": (1, 0)}, r"the second agent is at \(1, 0\); put it on a free cell"),
        ({"second": (0, 2)}, r"the second agent is in the closed door at \(0, 2\)"),
    ],
)
def test_agents_on_what_is_taken_are_refused(cells: dict, problem: str):
    with pytest.raises(ValueError, match=problem):
        replace(hb.World.parse(HOUSE), **cells)


def test_placements_that_are_none_are_refused():
    world = hb.World.parse(HOUSE)
    with pytest.raises(ValueError, match="give cells for agent, agent2, object"):
        hb.tabulate(world, starts=[{"agent": (0, 0)}])
    taken = start_of(world) | {"agent": (0, 3)}
    with pytest.raises(ValueError, match="share a cell"):
        hb.tabulate(world, starts=[taken])


def test_what_is_for_one_agent_refuses_two(tmp_path):
    world = hb.World.parse(HOUSE)
    (tmp_path / "house.txt").write_text(HOUSE)
    config = hb.Config(world=str(tmp_path / "house.txt"), episodes=1)
    for call in (
        lambda: pairs(world, 1),
        lambda: usefulness(world, 1),
        lambda: hb.compare(world, ["broom"], 1),
        lambda: world.with_tool("none"),
        lambda: hb.save_video([world], tmp_path / "two.gif"),
        lambda: hb.train(config),
        lambda: WorldEnv(world),
        lambda: drawn_of(world),
        lambda: Tiles.of(world),
    ):
        with pytest.raises(ValueError, match=r"two agents, and this is for one|has no tool"):
            call()
    assert not (tmp_path / "two.gif").exists()


def test_the_other_is_an_obstacle_of_empowerment():
    """Between a wall and the other agent there are as many cells as there are, one by one."""
    mdp = hb.tabulate(hb.World.parse(CORRIDOR))
    for first, second in product(range(5), repeat=2):
        if first >= second:
            continue
        state = mdp.find(agent=(0, first), agent2=(0, second))
        still = np.zeros((mdp.states, 5))
        still[:, 4] = 1
        found = hb.empowerment(mdp, 9, "agent", states=[state], player="agent", others=still)
        assert found[0] == np.log2(second)


def test_a_door_does_not_close_on_a_thing():
    world = hb.World.parse("E = agent\nD = open door\nACDE.")
    mdp = hb.tabulate(world)
    names = list(mdp.actions)
    pushed = int(mdp.next_state[mdp.start, names.index("east+stay")])
    assert mdp.factor("object")[pushed] == 2
    assert mdp.next_state[pushed, names.index("door+stay")] == pushed
    assert mdp.next_state[pushed, names.index("stay+door")] == pushed
    free = int(mdp.next_state[mdp.start, names.index("stay+door")])
    assert mdp.factor("door")[[mdp.start, free]].tolist() == [1, 0]
