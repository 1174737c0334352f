"""Landscapes and futures of puzzles."""

import numpy as np
import pytest

import habilis as hb
from habilis.analysis.futures import futures, futures_figure, sequence_text
from habilis.bridges import PushWorld

ROOM = PushWorld.parse("A A .  .\n. .  M1 M0\n. AW W  .\n. .  .  G0")


def test_every_cell_with_room_for_the_agent_has_the_value_of_that_state():
    found = hb.landscape(ROOM, 3, "object:m0")
    assert found.values.shape == ROOM.shape
    there = {
        (0, 0),
        (0, 1),
        (0, 2),
        (1, 0),
        (3, 0),
        (3, 1),
        (3, 2),
    }  # it takes the cell to the right
    assert {tuple(cell) for cell in np.argwhere(np.isfinite(found.values)).tolist()} == there
    for row, column in there:
        state = (4 * row + column, *ROOM.initial[1:])
        mdp = hb.explore(ROOM, [state], 3)
        assert found.values[row, column] == hb.empowerment(mdp, 3, "object:m0", states=[0])


def test_movables_can_be_put_elsewhere():
    found = hb.landscape(ROOM, 2, "object:m1", object={"m1": (3, 1)})
    assert found.world == ROOM.at((0, 7, 13))
    assert np.isnan(found.values[3, 0])
    away = hb.landscape(ROOM, 2, object={"m1": (0, 0)})  # the agent makes room
    assert away.world == ROOM.at((1, 7, 0))


def test_slips_make_values_smaller():
    sure, noisy = (hb.landscape(ROOM, 1, slip=slip).values for slip in (0.0, 0.3))
    assert (noisy[np.isfinite(noisy)] < sure[np.isfinite(sure)]).all()


def test_a_landscape_has_a_picture(tmp_path):
    hb.landscape(ROOM, 2).save(tmp_path / "room.png")
    assert (tmp_path / "room.png").stat().st_size > 1000


@pytest.mark.ill_typed
def test_what_a_puzzle_does_not_have_is_refused():
    with pytest.raises(ValueError, match="is a puzzle; leave out tool and mdp"):
        hb.landscape(ROOM, 2, tool=(0, 0))
    with pytest.raises(ValueError, match="give cells by names"):
        hb.landscape(ROOM, 2, object=(0, 0))
    with pytest.raises(ValueError, match="there is no movable 'm4'"):
        hb.landscape(ROOM, 2, object={"m4": (0, 0)})
    with pytest.raises(ValueError, match=r"the m1 is at \(9, 0\); put it on the map of 4 x 4"):
        hb.landscape(ROOM, 2, object={"m1": (9, 0)})


def test_futures_of_a_puzzle_are_arrows_on_its_map():
    puzzle = PushWorld.parse("A M0 . .")
    mdp = hb.explore(puzzle, horizon=2)
    found = futures(mdp, 0, 2, "object:m0")
    assert found.observations.tolist() == [1, 2, 3]
    assert "→→" in [sequence_text(mdp, sequence) for sequence in found.sequences]
    figure = futures_figure(puzzle, mdp, found, "object:m0")
    assert "3 cells" in figure.get_suptitle()


def test_long_sequences_have_room_beside_the_map():
    puzzle = PushWorld.parse("A M0 . .")
    mdp = hb.explore(puzzle)
    widths = []
    for horizon in (10, 30):
        found = futures(mdp, 0, horizon, "object:m0")
        widths.append(futures_figure(puzzle, mdp, found, "object:m0").get_figwidth() * 96)
    assert widths[1] - widths[0] == pytest.approx(30 * 9 - 110)
