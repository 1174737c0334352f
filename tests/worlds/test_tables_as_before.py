"""Worlds of one tool and one object: tables and bits are, byte for byte, what they were.

The digests are of the edition that knew nothing of several tools and objects.
"""

import pytest
from digests import bits_digest, table_digest

import habilis as hb

BEFORE = {
    # world, tool: digests of the table, of that with slip, and of bits
    ("corridor", "picker"): ("8f73cbaa43949062", "e3833f5bf66b8dc8", "b47403845ae31c81"),
    ("corridor", "broom"): ("f96f3d312145d9da", "857720282a316462", "21db2da3fada7938"),
    ("corridor", "none"): ("660bd21a7befffe6", "f61c13fecba1a775", "ad6732d744b7c7af"),
    ("yard", "picker"): ("9d50603ff7053747", "6439d3d14be36fd8", "6f9b9a53cc0c4222"),
    ("yard", "broom"): ("fb4e10155dc7fd8d", "f0681cfe8ecc6d4e", "06a880ec7bdb71a7"),
    ("yard", "none"): ("af1713af81a6b87b", "2324bd18be72aba3", "d34c16e78ca6ab2c"),
}


@pytest.mark.parametrize(("world", "tool"), BEFORE)
def test_the_table_of_one_tool_is_what_it_was(world, tool):
    table, slipping, bits = BEFORE[world, tool]
    alone = hb.load_world(world, tool=tool)
    mdp = hb.tabulate(alone)
    assert table_digest(mdp) == table
    assert table_digest(hb.tabulate(alone, slip=0.1)) == slipping
    assert bits_digest(mdp) == bits


def test_a_digest_depends_on_every_part_of_a_table():
    mdp = hb.tabulate(hb.World.parse("A.P.CG"))
    parts = mdp.next_state, mdp.reward, mdp.terminal, mdp.factor("object"), mdp.flags["attached"]
    reported = {table_digest(mdp)}
    for part in parts:
        was = part.flat[-1]
        part.flat[-1] = not was
        reported.add(table_digest(mdp))
        part.flat[-1] = was
    assert len(reported) == 1 + len(parts)
