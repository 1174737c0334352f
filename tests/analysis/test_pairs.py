"""Every tool by every object: each pair as it is alone."""

from dataclasses import replace

import numpy as np
import polars as pl
import pytest

import habilis as hb
from habilis.analysis.averages import average_empowerment, compare, compared_states
from habilis.analysis.influence import influence_range, latency, reliability
from habilis.analysis.pairs import MEASURES, Pairs, pairs
from habilis.benchmarks.pairs import one_by_one
from habilis.empowerment.tabular.persistence import persistence

ABOVE = "R = rake\nM = magnet\nD = ball\nK = crate\nG = goal of C\n"
ROOM = hb.World.parse(ABOVE + "A.P..\n..CR.\n.#..D\n.M.K.\n....G", "room")
SLIPS = hb.World.parse("P = picker slip 0.2\nQ = picker\nG = goal of C\nA.P\nQC.\n..G", "slips")


@pytest.fixture(scope="module")
def found():
    return pairs(ROOM, 3)


def test_rows_are_the_tools_of_the_map_and_none_and_columns_its_objects(found):
    assert found.tools == ("picker", "rake", "magnet", "none")
    assert found.objects == ("can", "ball", "crate")
    assert found.horizon == 3
    assert found.averages.shape == (3, 4, 3)


def test_each_average_is_that_of_the_world_with_that_tool_and_object_alone(found):
    for h, row, column in np.ndindex(found.averages.shape):
        pair = ROOM.with_tool(found.tools[row]).with_object(found.objects[column])
        alone = average_empowerment(hb.tabulate(pair), h + 1)
        assert found.averages[h, row, column] == alone


def test_the_benchmarks_way_gives_the_same(found):
    np.testing.assert_array_equal(one_by_one(ROOM, 3), found.averages)


def test_each_measure_is_that_of_the_pair_alone(found):
    for row, column in np.ndindex(4, 3):
        pair = ROOM.with_tool(found.tools[row]).with_object(found.objects[column])
        mdp = hb.tabulate(pair)
        states = compared_states(mdp)
        least = latency(mdp, 3, states=states)
        assert found.range[row, column] == influence_range(mdp, 3)
        assert found.latency[row, column] == least.min()
        assert found.median_latency[row, column] == np.median(least)
        assert found.persistence[row, column] == persistence(mdp, states=states).mean()
        assert found.reliability[row, column] == 1


def test_kinds_of_objects_and_tools_differ_in_what_the_measures_say(found):
    picker, _, magnet, none = range(4)
    can, ball, crate = range(3)
    assert found.averages[-1, picker, can] > found.averages[-1, none, can]
    assert found.averages[-1, picker, crate] < found.averages[-1, none, crate]
    assert found.range[magnet, can] > found.range[picker, can] > found.range[none, can]
    assert found.persistence[picker, ball] > found.persistence[none, ball]


def test_with_one_tool_and_object_averages_are_those_that_compare_gives():
    yard = hb.load_world("yard")
    found = pairs(yard, 3, ["broom", "none", "picker"])
    assert found.tools == ("broom", "none", "picker")
    averages = compare(yard, ["broom", "none", "picker"], 3)
    assert found.averages[-1, :, 0].tolist() == list(averages.values())


def test_a_tool_that_may_fail_is_measured_so_and_beside_one_that_does_not():
    found = pairs(SLIPS, 2)
    assert found.tools == ("picker", "picker2", "none")
    for row, tool in enumerate(SLIPS.tools):
        pair = SLIPS.with_tool(tool)
        assert [(one.slip, one.cell) for one in pair.tools] == [(tool.slip, tool.cell)]
        assert found.averages[-1, row, 0] == average_empowerment(hb.tabulate(pair), 2)
        assert found.reliability[row, 0] == reliability(pair, 2)
    assert found.reliability[0, 0] < found.reliability[1, 0] == found.reliability[2, 0] == 1
    assert found.persistence[0, 0] == found.persistence[1, 0]


def test_slipping_actions_make_every_pair_less_reliable():
    found = pairs(SLIPS, 2, slip=0.1)
    for row, tool in enumerate([*SLIPS.tools, "none"]):
        assert found.reliability[row, 0] == reliability(SLIPS.with_tool(tool), 2, slip=0.1) < 1


def test_where_things_start_and_whether_tools_can_be_put_down_makes_no_difference():
    above = ABOVE.replace("R = rake", "R = rake\ndrop: true")
    moved = hb.World.parse(above + ".MPKA\n..CR.\n.#..D\n.....\nG....", "room")
    assert all(moved.with_tool(tool).drop for tool in (moved.tools[0], "rake", Rod()))
    found = pairs(moved, 2)
    alike = pairs(ROOM, 2, found.tools, found.objects)
    assert found.tools != pairs(ROOM, 1).tools
    np.testing.assert_array_equal(found.averages, alike.averages)


def test_two_of_a_kind_are_measured_alike():
    two = hb.World.parse("D = can\nQ = picker\nG = goal of C\nAPC.\n.QD.\n...G")
    found = pairs(two, 2)
    assert found.objects == ("can", "can2")
    assert found.tools == ("picker", "picker2", "none")
    assert (found.averages[:, 0, 0] == found.averages[:, 1, 1]).all()
    alone = average_empowerment(hb.tabulate(two.with_tool(two.tools[1]).with_object("can2")), 2)
    assert found.averages[-1, 1, 1] == alone


class Rod:
    """A broom that is drawn otherwise."""

    character = "T"

    def __init__(self, works=True):
        self.works = works

    def attached(self, agent, tool, thing):
        return np.zeros(np.shape(thing), bool)

    def carry(self, agent, tool, thing, step):
        return np.where((tool + step == thing) & self.works, thing + step, thing)

    def swing(self, agent, tool, thing, step):
        return thing


def test_tools_of_ones_own_take_part():
    found = pairs(ROOM, 2, [Rod(), "broom"], ["can"])
    assert found.tools == (f"{__name__}:Rod", "broom")
    assert (found.averages[:, 0] == found.averages[:, 1]).all()
    idle = pairs(ROOM, 2, [Rod(works=False)], ["can"])
    assert (idle.averages[:, 0] < found.averages[:, 0]).all()
    own = replace(ROOM, tools=(*ROOM.with_tool(Rod()).tools, ROOM.tools[1]))
    assert pairs(own, 2, objects=["can"]).tools == ("Rod", "rake", "none")


def test_what_is_not_there_is_refused():
    for arguments, says in [
        ((0,), "horizon is 0; give a whole number from 1 up"),
        ((1, []), "no tools to compare; name some"),
        ((1, ["spoon"]), "tool 'spoon' is unknown"),
        ((1, None, []), "no objects; name some of can, ball, crate"),
        ((1, None, ["tin"]), "room has no 'tin'; name one of can, ball, crate"),
        ((1, [Rod(), Rod()]), r"two of the tools have one name, '.*Rod'"),
        ((1, None, None, 1.5), "slip is 1.5; give a probability"),
    ]:
        with pytest.raises(ValueError, match=says):
            pairs(ROOM, *arguments)
    with pytest.raises(ValueError, match=r"horizon 9 takes about .*largest horizon that fits"):
        pairs(ROOM, 9, slip=0.1, method=hb.Exact(max_seconds=1.0))


def test_nats_are_fewer_than_bits(found):
    nats = pairs(ROOM, 3, unit="nats")
    np.testing.assert_allclose(nats.averages, found.averages * np.log(2))
    np.testing.assert_allclose(nats.persistence, found.persistence * np.log(2))
    np.testing.assert_array_equal(nats.latency, found.latency)
    assert nats.unit in nats.to_dataframe().columns


def test_a_data_frame_has_a_row_for_each_tool_object_and_horizon(found):
    table = found.to_dataframe()
    assert table.columns == ["tool", "object", "horizon", "bits", *MEASURES]
    assert len(table) == found.averages.size
    for row in table.rows(named=True):
        pair = found.tools.index(row["tool"]), found.objects.index(row["object"])
        assert row["bits"] == found.averages[row["horizon"] - 1, *pair]
        for name in MEASURES:
            value = getattr(found, name)[pair]
            assert row[name] == (value if np.isfinite(value) else None)


def test_infinity_and_what_is_no_number_are_nulls():
    walled = pairs(hb.World.parse("A#C\n..#\n..G"), 2)
    assert np.isinf(walled.median_latency).all()
    assert np.isnan(pairs(hb.World.parse("A#C#G"), 1).reliability).all()
    table = pairs(hb.World.parse("A#C#G"), 1).to_dataframe()
    assert table.select("range", "latency", "median_latency", "reliability").rows() == [
        (0, None, None, None)
    ]


@pytest.mark.parametrize("suffix", ["csv", "parquet", "npz", "npy", "png", "svg", "pdf"])
def test_values_and_pictures_are_saved_by_the_suffix(found, suffix, tmp_path):
    path = tmp_path / f"pairs.{suffix}"
    found.save(path)
    if suffix == "npy":
        np.testing.assert_array_equal(np.load(path), found.averages)
    elif suffix == "npz":
        np.testing.assert_array_equal(np.load(path)["bits"], found.to_dataframe()["bits"])
    elif suffix in ("csv", "parquet"):
        read = pl.read_csv if suffix == "csv" else pl.read_parquet
        assert read(path).equals(found.to_dataframe())
    else:
        begins = {"png": b"\x89PNG", "svg": b"<?xml", "pdf": b"%PDF"}[suffix]
        assert path.read_bytes().startswith(begins)
        again = tmp_path / f"again.{suffix}"
        found.save(again)
        assert again.read_bytes() == path.read_bytes()


def test_another_suffix_is_refused_and_nothing_written(found, tmp_path):
    with pytest.raises(ValueError, match=r"unknown suffix '.bmp'; let the name end with .png"):
        found.save(tmp_path / "pairs.bmp")
    assert not list(tmp_path.iterdir())


def test_the_picture_has_the_matrix_and_a_panel_of_curves_for_each_object(found):
    matrix, *panels = found.draw().axes
    shown = [float(text.get_text()) for text in matrix.texts]
    np.testing.assert_allclose(shown, found.averages[-1].ravel(), atol=0.005001)
    assert [label.get_text() for label in matrix.get_yticklabels()] == list(found.tools)
    assert [label.get_text() for label in matrix.get_xticklabels()] == list(found.objects)
    assert [ax.get_title() for ax in panels] == list(found.objects)
    for column, ax in enumerate(panels):
        for row, line in enumerate(ax.lines):
            assert line.get_label() == found.tools[row]
            np.testing.assert_array_equal(line.get_xdata(), [1, 2, 3])
            np.testing.assert_array_equal(line.get_ydata(), found.averages[:, row, column])


def test_curves_are_distinguishable_by_more_than_colour():
    tools, ones = tuple(f"tool{n}" for n in range(20)), np.ones((20, 1))
    rest = ones.astype(int), ones, ones, ones, ones
    many = Pairs(tools, ("can",), np.ones((2, 20, 1)), *rest)
    lines = many.draw().axes[1].lines
    looks = {(line.get_color(), line.get_linestyle()) for line in lines}
    assert len(looks) == 20
    assert len({str(line.get_marker()) for line in lines[:7]}) == 7


def test_a_notebook_shows_the_picture(found):
    assert found._repr_png_().startswith(b"\x89PNG")
