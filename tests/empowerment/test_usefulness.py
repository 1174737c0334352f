"""Whether a tool is of use, in every placement and on average."""

import json
import re

import numpy as np
import pytest

import habilis as hb
from habilis.cli import main
from habilis.empowerment.measures import average_empowerment, compare
from habilis.empowerment.usefulness import usefulness

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
        "useful_share": pytest.approx(found.useful.mean()),
        "better_than_none_share": pytest.approx(found.better_than_none.mean()),
    }
