"""The plain search that the table of several things is measured against finds the same."""

import habilis as hb
from habilis.benchmarks.placements import plain_search

ROOM = "R = rake\nM = magnet\nD = can\nG = goal of C\nH = goal of D\nA...P\n..C..\nR..D.\nH.M.G\n"


def test_the_plain_search_leads_where_the_table_does():
    world = hb.World.parse(ROOM)
    mdp = hb.tabulate(world)
    leads = plain_search(world)
    assert len(leads) == mdp.states > 1_000

    names = [name for name in mdp.factors if name != "held"]

    def key(at):
        agent, tools, objects, held = at
        return (*(mdp.label(cell) for cell in (agent, *tools, *objects)), held)

    columns = [mdp.factors[name].tolist() for name in (*names, "held")]
    place = {row: state for state, row in enumerate(zip(*columns, strict=True))}
    for at, to in leads.items():
        assert mdp.next_state[place[key(at)]].tolist() == [place[key(one)] for one in to]
