"""Whether a tool is of use, in every placement and on average."""

import json
import re
from typing import Any

import numpy as np
import pytest

import habilis as hb
from habilis.analysis.averages import average_empowerment, compare
from habilis.analysis.usefulness import Usefulness, usefulness
from habilis.cli import main

SMALL = hb.World.parse("A.P.\n..C.\n.#..\n...G", name="small")


@pytest.mark.parametrize("tool", ["picker", "broom"])
@pytest.mark.parametrize("slip", [0.0, 0.2])
def test_every_placement_is_judged_beside_the_same_without_the_tool(tool: str, slip: float):
    world = SMALL.with_tool(tool)
    found = usefulness(world, 2, slip)
    mdp, bare = hb.tabulate(world, slip), hb.tabulate(world.with_tool("none"), slip)
    assert np.array_equal(found.states, np.flatnonzero(mdp.flags["equipped"]))
    for i in range(0, len(found.states), 7):
        state = found.states[i]
        cells = {
            name: divmod(int(mdp.factor(name)[state]), world.width) for name in ("agent", "object")
        }
        alone = hb.empowerment(bare, 2, "object", states=[bare.find(**cells)])[0]
        armed = hb.empowerment(mdp, 2, "object", states=[state])[0]
        assert found.with_tool[i] == pytest.approx(armed, abs=2e-6)
        assert found.without[i] == pytest.approx(alone, abs=2e-6)
        assert found.useful[i] == (armed > 1e-9)
        assert found.better_than_none[i] == (armed > alone + 2e-6)
        assert found.encumbers[i] == (alone > armed + 2e-6)


def test_averages_are_those_that_compare_gives():
    averages = compare(SMALL, ["picker", "none"], 3)
    found = usefulness(SMALL, 3)
    assert found.average_with_tool == pytest.approx(averages["picker"])
    assert found.average_without == pytest.approx(averages["none"])
    assert found.useful_on_average
    assert found.better_than_none_on_average == (averages["picker"] > averages["none"])


def test_a_broom_in_a_narrow_place_encumbers():
    crossing = hb.World.parse("#A#\nBC.\n#G#", name="crossing")
    found = usefulness(crossing, 2)
    assert found.average_without == 0.2  # 1 bit in 4 of 20 placements
    assert found.average_with_tool == 0
    assert not found.better_than_none_on_average
    assert found.encumbers_on_average
    assert not found.useful_on_average
    room = usefulness(hb.World.parse("AB.\n.C.\n..G", name="room"), 4)
    assert not room.better_than_none_on_average
    assert (room.with_tool < room.without).any()
    assert (room.with_tool > room.without).any()


def test_no_actions_are_of_no_use():
    found = usefulness(SMALL, 0)
    assert not found.useful.any()
    assert not found.better_than_none.any()
    assert not found.useful_on_average
    assert not found.better_than_none_on_average
    assert not found.encumbers.any()
    assert not found.encumbers_on_average


@pytest.mark.parametrize(
    ("with_tool", "without", "gaps", "better", "encumbers"),
    [
        (0.5, 0.5, (0, 0), False, False),
        (0.1 + 0.2, 0.3, (0, 0), False, False),  # equal but for rounding, which makes it larger
        (0.3, 0.1 + 0.2, (0, 0), False, False),
        (0.5 + 1e-8, 0.5, (0, 0), True, False),
        (0.5, 0.5 + 1e-8, (0, 0), False, True),
        (0.5 + 1e-7, 0.5, (0, 1e-6), False, False),  # the other may be larger by its gap
        (0.5, 0.5 + 1e-7, (1e-6, 0), False, False),
        (0.5, 0.5 + 1e-7, (0, 1e-6), False, True),  # its own gap makes it larger still
        (0.5 + 1e-7, 0.5, (1e-6, 0), True, False),
    ],
)
def test_a_difference_counts_where_it_is_certain(with_tool, without, gaps, better, encumbers):
    none: Any = [np.zeros(0, kind) for kind in (np.int64, float, float, bool, bool, bool)]
    values: Any = (*none, with_tool, without, *gaps)
    found = Usefulness(*values)
    assert found.better_than_none_on_average == better
    assert found.encumbers_on_average == encumbers


def test_where_nothing_can_be_done_to_the_can_the_tool_neither_helps_nor_encumbers():
    """The agent and its tool are walled in, so with it and without the can stays where it is."""
    apart = hb.World.parse("AP###\n#####\n###CG", name="apart")
    for slip in (0.0, 0.3):
        found = usefulness(apart, 2, slip)
        assert found.average_with_tool == found.average_without == 0
        assert not (found.encumbers | found.better_than_none).any()
        assert not found.better_than_none_on_average
        assert not found.encumbers_on_average


def test_the_command_line_calls_a_tie_a_tie(capsys: pytest.CaptureFixture[str]):
    assert main(["compare", "yard", "--horizon", "0"]) == 0
    tie = "equal to none (better in 0% of placements, worse in 0%; useful in 0%)"
    assert [line.split(maxsplit=2) for line in capsys.readouterr().out.splitlines()[1:]] == [
        ["picker", "0.0000", tie],
        ["broom", "0.0000", tie],
        ["none", "0.0000"],
    ]
    assert main(["compare", "yard", "--horizon", "0", "--json"]) == 0
    judged = json.loads(capsys.readouterr().out)["tools"]["picker"]
    assert not judged["better_than_none"]
    assert not judged["encumbers"]
    assert judged["equal"]


def test_the_maps_own_tools_are_compared_first_and_as_the_map_has_them(tmp_path, capsys):
    text = "P = picker slip 0.5\nR = rake\nS = rake slip 1\nAP.C.\n....R\n...GS\n"
    (tmp_path / "shop.txt").write_text(text)
    assert main(["compare", str(tmp_path / "shop.txt"), "--horizon", "2", "--json"]) == 0
    averages = json.loads(capsys.readouterr().out)["averages"]
    assert list(averages) == ["picker", "rake", "rake2", "broom", "none"]
    world = hb.World.parse(text)
    for name, tool in zip(("picker", "rake", "rake2"), world.tools, strict=True):
        alone = hb.tabulate(world.with_tool(tool))
        assert averages[name] == pytest.approx(average_empowerment(alone, 2), abs=2e-6)
    sure = hb.tabulate(hb.World.parse(text.replace("slip 0.5", "slip 0")).with_tool("picker"))
    assert averages["picker"] < average_empowerment(sure, 2)
    assert averages["rake2"] < averages["rake"]
    assert compare(world, ["rake2"], 2) == {"rake2": averages["rake2"]}


def test_a_world_without_a_tool_is_refused():
    with pytest.raises(ValueError, match="small has no tool to judge; give it one"):
        usefulness(SMALL.with_tool("none"), 1)


def test_every_measure_speaks_nats_too():
    ln2 = np.log(2)
    mdp = hb.tabulate(SMALL)
    assert average_empowerment(mdp, 2, unit="nats") == pytest.approx(
        ln2 * average_empowerment(mdp, 2)
    )
    bits, nats = compare(SMALL, ["picker"], 2), compare(SMALL, ["picker"], 2, unit="nats")
    assert nats["picker"] == pytest.approx(ln2 * bits["picker"])
    assert usefulness(SMALL, 2, unit="nats").average_without == pytest.approx(
        ln2 * usefulness(SMALL, 2).average_without
    )


def test_slip_takes_away_from_every_measure():
    for tool, bits in compare(SMALL, ["picker", "broom", "none"], 2, slip=0.3).items():
        assert bits < compare(SMALL, [tool], 2)[tool]


def test_the_command_line_says_useful_and_better(capsys: pytest.CaptureFixture[str]):
    arguments = ["compare", "yard", "--horizon", "3", "--tools", "picker,broom,none"]
    assert main(arguments) == 0
    lines = capsys.readouterr().out.splitlines()
    assert re.fullmatch(
        r" +picker  0\.5241  better than none \(in \d+% of placements; useful in \d+%\)", lines[1]
    )
    assert main([*arguments, "--json", "--unit", "nats"]) == 0
    answer = json.loads(capsys.readouterr().out)
    assert answer["averages"]["picker"] == pytest.approx(0.5241 * np.log(2), abs=1e-4)
    found = usefulness(hb.load_world("yard", tool="broom"), 3)
    assert answer["tools"]["broom"] == {
        "useful": True,
        "better_than_none": True,
        "encumbers": False,
        "equal": False,
        "gap": 0,
        "useful_share": pytest.approx(found.useful.mean()),
        "better_than_none_share": pytest.approx(found.better_than_none.mean()),
        "encumbers_share": pytest.approx(found.encumbers.mean()),
    }
