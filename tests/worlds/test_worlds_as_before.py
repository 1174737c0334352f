"""Worlds of any number of things: tables, landscapes, map text and pictures are what they were.

The digests are of the edition in which a world had a first tool and a first object, and more
besides.
"""

from typing import Any

import numpy as np
import pytest
from digests import digest, table_digest

import habilis as hb
from habilis.envs.observations import observation
from habilis.worlds.pictures.figures import colored_text, frame
from habilis.worlds.placements import start_of
from habilis.worlds.reach import reachable

_TWO = "R = rake\nD = ball\nG = goal of C\nH = goal of D\nA....\n.PCR.\n.D#.H\n....G\n"
_ROOM = "APC..\n.#...\n....G\n"

WORLDS = {
    "yard": hb.load_world("yard"),
    "no tool": hb.load_world("yard", tool="none"),
    "another tool": hb.load_world("corridor", tool="rake"),
    "never a tool": hb.World.parse("A.C\n#..\n..G", "map"),
    "two of each": hb.World.parse(_TWO, "map"),
    "down": hb.World.parse(f"drop: true\n{_ROOM}", "map"),
    "down, two": hb.World.parse(
        "R = rake\nD = ball\nG = goal of C\nH = goal of D\ndrop: true\nAPC.\nRD.G\n#..H", "map"
    ),
    "two tools": hb.World.parse("B..\nA.P\n.CG", "map"),
    "two pickers that fail": hb.World.parse(
        "P = picker slip 0.25\nQ = picker slip 0.5\nAPC.\nQ...\n...G", "map"
    ),
    "fails": hb.World.parse(f"P = picker slip 0.25\n{_ROOM}", "map"),
    "readings": hb.World.parse(
        "P = picker pushes sweeps\nB = broom shoves sticky\nAPC.\nB...\n...G", "map"
    ),
    "reading": hb.World.parse(f"P = picker shoves sweeps slip 0.5\n{_ROOM}", "map"),
    "reading of another tool": hb.World.parse(f"P = picker pushes sticky\n{_ROOM}", "map")
    .with_tool("none")
    .with_tool("broom"),
    "two objects": hb.World.parse("D = crate\nG = goal of C\nA.C.\n..D.\n...G", "map"),
    "two cans, no tool": hb.World.parse(
        "D = can\nG = goal of D\nA.C.\nP.D.\n...G", "map"
    ).with_tool("none"),
    "the second tool": hb.World.parse(_TWO, "map").with_tool("rake"),
    "a tool of several": hb.World.parse(_TWO, "map").with_tool("broom"),
    "the second object": hb.World.parse(_TWO, "map").with_object("ball"),
    "one of each": hb.World.parse(_TWO, "map").with_tool("picker").with_object("ball"),
    "a crate alone": hb.World.parse("E = crate\nAPEG\n....\n....", "map"),
}


@pytest.mark.parametrize("name", WORLDS)
def test_a_world_is_what_it_was(name):
    world = WORLDS[name]
    mdp = hb.tabulate(world)
    pixels = frame(world, 16)
    text = colored_text(world)
    reached = reachable(world, start_of(world), 3)[0]
    placed = hb.placement(world, mdp, mdp.states // 2)
    seen = [
        observation(kind, mdp, world).show(np.arange(mdp.states)) for kind in ("factors", "grid")
    ]
    assert {
        "table": table_digest(mdp),
        "slip": table_digest(hb.tabulate(world, slip=0.1)),
        "reached": table_digest(reached),
        "text": digest(world.text(), world.rows),
        "picture": digest(pixels, text.plain, [str(span.style) for span in text.spans]),
        "placement": digest(placed.rows, frame(placed, 8)),
        "shown": digest(*seen),
    } == BEFORE[name]


LANDSCAPES: dict[str, tuple[str, str, dict[str, Any]]] = {
    # world, sensor, and what is asked besides
    "of the map": ("yard", "object", {}),
    "tool elsewhere": ("yard", "state", {"tool": (2, 3)}),
    "object elsewhere, slip": ("reading", "object", {"object": (2, 0), "slip": 0.1}),
    "by name": ("yard", "object", {"tool": {"picker": (0, 1)}, "object": {"can": (8, 8)}}),
    "no tool": ("no tool", "agent", {"object": (3, 3)}),
    "two of each": ("two of each", "object:ball", {}),
    "two of each, elsewhere": (
        "two of each",
        "tool:rake",
        {"tool": {"rake": (0, 0)}, "object": {"ball": (3, 0)}},
    ),
    "down": ("down", "held", {"slip": 0.2}),
}


@pytest.mark.parametrize("asked", LANDSCAPES)
def test_a_landscape_is_what_it_was(asked):
    name, sensor, options = LANDSCAPES[asked]
    found = hb.landscape(WORLDS[name], 2, sensor, **options)
    values = np.round(found.values, 9) + 0.0
    assert isinstance(found.world, hb.World)
    assert digest(values, found.title, found.world.rows) == LANDSCAPES_BEFORE[asked]


def test_a_landscape_of_a_table_is_what_it_was():
    found = {}
    for name, sensor in (("yard", "object"), ("two of each", "object:ball"), ("down", "agent")):
        mdp = hb.tabulate(WORLDS[name])
        labels = mdp.factor(sensor)
        each = [hb.landscape(WORLDS[name], 2, one, mdp=mdp).values for one in (sensor, labels)]
        each.append(hb.landscape(WORLDS[name], 2, labels).values)
        found[name] = digest(*(np.round(values, 9) + 0.0 for values in each))
    assert found == OF_TABLES_BEFORE


@pytest.mark.parametrize("tool", ["picker", "none"])
def test_a_landscape_of_a_map_too_large_for_its_table_is_what_it_was(tool):
    rows = ["." * 30 for _ in range(30)]
    rows[3] = "..APC.#G".ljust(30, ".")
    world = hb.World.parse("\n".join(rows), "hall").with_tool(tool)
    at: dict[str, Any] = {"object": (9, 9)} | ({} if tool == "none" else {"tool": (10, 10)})
    each = [hb.landscape(world, 2, "object"), hb.landscape(world, 2, "object", **at)]
    values = [np.round(one.values, 9) + 0.0 for one in each]
    shown = [one.world for one in each]
    agents = [shown_world.agent for shown_world in shown if isinstance(shown_world, hb.World)]
    assert digest(*values, *agents) == LARGE_BEFORE[tool]


BEFORE = {
    "yard": {
        "table": "9d50603ff7053747",
        "slip": "6439d3d14be36fd8",
        "reached": "16ed777cbe6dbba6",
        "text": "675663e045ab1ba5",
        "picture": "a4354f80df57167b",
        "placement": "2c5e4c1d49b37728",
        "shown": "a9e8ee199a5798bf",
    },
    "no tool": {
        "table": "af1713af81a6b87b",
        "slip": "2324bd18be72aba3",
        "reached": "d972ce092a1ee52a",
        "text": "49e03b6645a6d639",
        "picture": "0a4dac2e85aec650",
        "placement": "79641d6675af36a0",
        "shown": "1a753bc519fb6026",
    },
    "another tool": {
        "table": "097ef29e7f47d67b",
        "slip": "525001d625d38c92",
        "reached": "c5e6ddea9748539d",
        "text": "29a3d0a798d3dd69",
        "picture": "c84084b0b2a6dee6",
        "placement": "30f0aaf723125d71",
        "shown": "7c4e161ab8ad0373",
    },
    "never a tool": {
        "table": "0d3cd84f099e0b87",
        "slip": "24a74dd2d79dd3dc",
        "reached": "7d91ffb1252ae313",
        "text": "2dbf59b5aaf12176",
        "picture": "05c99085acc38017",
        "placement": "6511c3d3af86fa39",
        "shown": "5b404b6b3e03d44f",
    },
    "two of each": {
        "table": "d8f9ac8ace187a1c",
        "slip": "666803109ba874cd",
        "reached": "4bbe8750f957a2a6",
        "text": "2ba834b5049a00bb",
        "picture": "8c65ecbb934f6d7b",
        "placement": "a2a5d3ab748e0762",
        "shown": "acbf8cce1ecacaf0",
    },
    "down": {
        "table": "5f2df01c036ce480",
        "slip": "b16d38069dabcb8c",
        "reached": "359c3e73167b62b6",
        "text": "bdcbd41ce30028ab",
        "picture": "f8c6b6ae24f5dc85",
        "placement": "ee08677e9a47d529",
        "shown": "089d9bf2591897d6",
    },
    "down, two": {
        "table": "6b7fac0e92840e42",
        "slip": "e443e081fb791453",
        "reached": "f033bc02d772ac99",
        "text": "f4a2bf92765afdb5",
        "picture": "00b08baaa950db4d",
        "placement": "bb025ec88194caeb",
        "shown": "ccdb9c57ebd25618",
    },
    "two tools": {
        "table": "e16b41a4c094d95f",
        "slip": "fe79ea7f820fdfdf",
        "reached": "324cf0ce338bf4f8",
        "text": "721a13d79be495a0",
        "picture": "519734bccb302e9a",
        "placement": "7302f68e62b2972d",
        "shown": "e8907d4788deb4d5",
    },
    "two pickers that fail": {
        "table": "bdb52e62972c7741",
        "slip": "94d318c59998ba2c",
        "reached": "d0c7f4739c65bae1",
        "text": "ff9ee9071a8d0078",
        "picture": "32052d83afbe7639",
        "placement": "58429828a5db66c2",
        "shown": "114e5d06ae8d391b",
    },
    "fails": {
        "table": "94063cdf91b2e5c4",
        "slip": "90930f85944ab181",
        "reached": "6867cc18fd700e70",
        "text": "e72e25c61f058a5a",
        "picture": "bd92b33daaa4b054",
        "placement": "5990a7dbdb232c72",
        "shown": "41d2dd21f8e3ff51",
    },
    "readings": {
        "table": "9648ec08b2706d7e",
        "slip": "c4cdd37f75c7917f",
        "reached": "78e912af296d01b2",
        "text": "03b3cea968eaf260",
        "picture": "8268d95a73275f5c",
        "placement": "662057066330e0b6",
        "shown": "9de76470c27e41d4",
    },
    "reading": {
        "table": "610c4377d47bc2e5",
        "slip": "47eeddac57fd5022",
        "reached": "7c287fa080d29542",
        "text": "1c08846220c0b348",
        "picture": "bd92b33daaa4b054",
        "placement": "5990a7dbdb232c72",
        "shown": "41d2dd21f8e3ff51",
    },
    "reading of another tool": {
        "table": "a7c2375fa619e430",
        "slip": "fb05b0800b138ccb",
        "reached": "52b20f9177da8d90",
        "text": "ee7aee96e55edf5e",
        "picture": "8d06c9e32c53036f",
        "placement": "f59610dbc1af3a5c",
        "shown": "41d2dd21f8e3ff51",
    },
    "two objects": {
        "table": "a20364fa6aa8b271",
        "slip": "737a0e66612a9d2d",
        "reached": "f7c16134100e499a",
        "text": "1eec1a2b194922d0",
        "picture": "ce14a554e44153a6",
        "placement": "7e3edf6df7f28ff4",
        "shown": "5861d8216c575b96",
    },
    "two cans, no tool": {
        "table": "e63c21632a7a3daf",
        "slip": "009871f6c42d2838",
        "reached": "bfd7013334a5905a",
        "text": "655a7b58b26c3233",
        "picture": "e23b2cae29365d0f",
        "placement": "e99b3a441016d166",
        "shown": "f5910d0609944640",
    },
    "the second tool": {
        "table": "d7af9aa529b8afc9",
        "slip": "6a44b9a444f09293",
        "reached": "f1ceaca2848f7675",
        "text": "0e523b701ffb0f8e",
        "picture": "07f6f2dd6d09f379",
        "placement": "6588f879a6cfb641",
        "shown": "4471d42bebec724e",
    },
    "a tool of several": {
        "table": "339b77166929db3b",
        "slip": "8666eb7d6d3240fb",
        "reached": "39b0458ee7d62690",
        "text": "24a3402caffe7637",
        "picture": "bfd445d8b9ad96f3",
        "placement": "3da44c1b97956407",
        "shown": "8fe9300950d573c4",
    },
    "the second object": {
        "table": "813d4b5a51238625",
        "slip": "17f5d1cfd97db9d5",
        "reached": "527b92704a3db7b8",
        "text": "c6c1ff6383744b94",
        "picture": "078e3a03e0f79434",
        "placement": "52a39ee1d47ecdd1",
        "shown": "d0abc391918fd5c4",
    },
    "one of each": {
        "table": "f2f857ccdeab08f0",
        "slip": "a630000d8c249b00",
        "reached": "af9e514a98a35ab7",
        "text": "a0aa761c77736a0f",
        "picture": "b5392e1b30f96dc8",
        "placement": "e433d63660aa2682",
        "shown": "6af0134e42bb29c2",
    },
    "a crate alone": {
        "table": "29f60fbb40584498",
        "slip": "35dd44cae898a059",
        "reached": "a113af6545eaf8e6",
        "text": "0c0ee60e472b837f",
        "picture": "7fd44a73e5755619",
        "placement": "5cdb979fc95bb4a7",
        "shown": "a1a6a12ce88a9bae",
    },
}

LANDSCAPES_BEFORE = {
    "of the map": "94dfad1b59421c84",
    "tool elsewhere": "9e2d567b06436833",
    "object elsewhere, slip": "2aaecf7dfb6828da",
    "by name": "8ec7b33dff72d91a",
    "no tool": "c41d1d1fc29daab5",
    "two of each": "9b5024de7ad3c7b5",
    "two of each, elsewhere": "14771aba92295f84",
    "down": "443e3fbcd90328b4",
}

OF_TABLES_BEFORE = {
    "yard": "30de8443492e0bba",
    "two of each": "28b6f1668876fcea",
    "down": "307cb6af545be0d5",
}

LARGE_BEFORE = {"picker": "92fc09dca4bc4e87", "none": "e84b71506d098f89"}
