"""A landscape has the value of each agent cell, draws itself, and goes into files."""

import subprocess
import sys
from dataclasses import replace
from io import BytesIO
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
import polars as pl
import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from PIL import Image

import habilis as hb
from habilis.analysis import landscape_states
from habilis.cli import main

ROOM = hb.World.parse("A..\nP#.\n.C.\n..G\n", "room")
SUFFIXES = [".png", ".svg", ".pdf", ".csv", ".parquet", ".npz", ".npy"]


@pytest.fixture(scope="module")
def found() -> hb.Landscape:
    return hb.landscape(ROOM, 2, "object")


def pixels(figure: Figure) -> np.ndarray:
    canvas = FigureCanvasAgg(figure)
    canvas.draw()
    return np.asarray(canvas.buffer_rgba()).copy()


def heats(figure: Figure) -> list:
    every = [areas for ax in figure.axes for areas in ax.collections]
    return [areas for areas in every if areas.get_array() is not None]


def test_it_has_the_value_of_each_agent_cell(found: hb.Landscape):
    mdp = hb.tabulate(ROOM)
    bits = hb.empowerment(mdp, 2, "object")
    for cell in np.ndindex(4, 3):
        try:
            expected = bits[mdp.find(agent=cell, tool=(1, 0), object=(2, 1))]
        except KeyError:
            expected = np.nan
        np.testing.assert_equal(found.values[cell], expected)
    assert np.isnan(found.values[1, 1])
    assert np.isfinite(found.values).sum() == 12 - 3
    assert found.unit == "bits"


def test_things_can_be_elsewhere_and_then_the_tool_is_in_hand():
    moved = hb.landscape(ROOM, 1, tool=(3, 1), object=(0, 2))
    assert sorted(map(tuple, np.argwhere(np.isfinite(moved.values)))) == [(2, 1), (3, 0), (3, 2)]
    assert isinstance(moved.world, hb.World)
    assert (moved.world.tool_cell, moved.world.object) == ((3, 1), (0, 2))
    assert moved.world.walls == ROOM.walls


def test_things_can_be_where_the_map_has_the_agent():
    on_start = hb.landscape(ROOM, 1, object=ROOM.agent)
    assert isinstance(on_start.world, hb.World)
    assert on_start.world.object == ROOM.agent
    assert np.isnan(on_start.values[ROOM.agent])


def test_actions_slip_unit_and_a_table_at_hand_are_as_in_empowerment(found: hb.Landscape):
    assert np.nanmax(hb.landscape(ROOM, 1, actions=[0]).values) == 0
    nats = hb.landscape(ROOM, 2, "object", unit="nats")
    np.testing.assert_allclose(nats.values, np.log(2) * found.values)
    assert nats.unit == "nats"
    slippery = hb.landscape(ROOM, 2, "object", slip=0.3).values
    there = found.values > 0
    assert (slippery[there] < found.values[there]).all()
    again = hb.landscape(ROOM, 2, "object", mdp=hb.tabulate(ROOM, slip=0.3))
    np.testing.assert_array_equal(again.values, slippery)


def test_a_bare_agent_has_a_landscape():
    bare = hb.landscape(ROOM.with_tool("none"), 2, "object")
    assert np.isfinite(bare.values).sum() == 12 - 2


def test_what_cannot_be_measured_is_refused():
    for tool, thing in (((1, 0), (1, 1)), ((1, 0), (1, 5)), ((2, 1), None)):
        with pytest.raises(ValueError, match="give two distinct free cells"):
            hb.landscape(ROOM, 1, tool=tool, object=thing)
    with pytest.raises(ValueError, match="has no tool here"):
        hb.landscape(ROOM.with_tool("none"), 1, tool=(1, 0))
    with pytest.raises(ValueError, match="of another map"):
        hb.landscape(ROOM, 1, mdp=hb.tabulate(hb.load_world("yard")))
    with pytest.raises(ValueError, match="slip"):
        hb.landscape(ROOM, 1, slip=0.1, mdp=hb.tabulate(ROOM))
    with pytest.raises(ValueError, match="horizon"):
        hb.landscape(ROOM, -1)


def test_it_draws_on_any_axes(found: hb.Landscape):
    figure, axes = plt.subplots(1, 2)
    heat = found.draw(axes[1], vmin=0, vmax=4, title="mine")
    assert heat.axes is axes[1]
    assert heat.get_clim() == (0, 4)
    assert axes[1].get_title() == "mine"
    assert not axes[0].collections
    assert len(axes[1].artists) == 1
    figure.colorbar(heat, ax=axes[1], label=found.unit)
    figure.canvas.draw()
    plt.close(figure)


def test_without_axes_it_draws_on_the_current_ones(found: hb.Landscape):
    figure, axes = plt.subplots(1, 2)
    plt.sca(axes[0])
    assert found.draw(labels=False).axes is axes[0]
    assert not axes[0].artists
    assert axes[0].get_title() == "2-step empowerment, sensor 'object'"
    plt.close(figure)


def test_it_can_be_drawn_at_once():
    figure = Figure()
    drawn = hb.landscape(ROOM, 2, "object", ax=figure.add_subplot())
    shown = heats(figure)[0].get_array()
    np.testing.assert_array_equal(shown, drawn.values[np.isfinite(drawn.values)])


def test_panels_share_the_scale_of_one_bar(found: hb.Landscape):
    higher = replace(found, values=found.values + 4)
    figure = hb.draw_landscapes({"low": found, "high": higher})
    *panels, bar = figure.axes
    assert [ax.get_title() for ax in panels] == ["low", "high"]
    ends = np.nanmin(found.values), np.nanmax(found.values) + 4
    assert [heat.get_clim() for heat in heats(figure)[:2]] == [ends] * 2
    assert bar.get_ylabel() == "bits"
    assert bar.get_ylim() == ends


def test_panels_of_different_maps_have_the_same_cells():
    wide = hb.landscape(hb.World.parse("AP.CG.."), 1)
    figure = hb.draw_landscapes({"room": hb.landscape(ROOM, 1), "wide": wide}, cell=30)
    figure.canvas.draw()
    one, other = (ax.get_window_extent() for ax in figure.axes[:2])
    assert (one.width, one.height) == pytest.approx((3 * 30, 4 * 30))
    assert (other.width, other.height) == pytest.approx((7 * 30, 30))
    assert one.y1 == pytest.approx(other.y1)


@pytest.mark.parametrize("layout", [None, "constrained", "compressed"])
def test_panels_go_on_axes_of_ones_own(found: hb.Landscape, layout: str | None):
    figure, axes = plt.subplots(2, 2, figsize=(9, 4), layout=layout)
    drawn = hb.draw_landscapes({f"panel {n}": found for n in range(4)}, axes)
    assert drawn is figure
    figure.canvas.draw()
    bar = figure.axes[-1]
    assert bar.get_ylabel() == "bits"
    maps = [ax.get_window_extent() for ax in axes.flat]
    around = bar.get_window_extent()
    assert around.x0 > max(box.x1 for box in maps)
    assert figure.bbox.contains(around.x1, around.y1)
    if layout is None:
        assert around.y1 == pytest.approx(max(box.y1 for box in maps), abs=1)
        assert around.y0 == pytest.approx(min(box.y0 for box in maps), abs=1)
    plt.close(figure)


def test_one_landscape_goes_on_one_axes_with_a_bar(found: hb.Landscape):
    figure, ax = plt.subplots()
    hb.draw_landscapes({"one": found}, ax)
    assert len(figure.axes) == 2
    plt.close(figure)


def test_panels_that_do_not_fit_are_refused(found: hb.Landscape):
    with pytest.raises(ValueError, match="no landscapes"):
        hb.draw_landscapes({})
    with pytest.raises(ValueError, match="bits and nats; give one unit"):
        hb.draw_landscapes({"a": found, "b": replace(found, unit="nats")})
    with pytest.raises(ValueError, match="1 landscapes on 2 axes"):
        hb.draw_landscapes({"a": found}, Figure().subplots(1, 2))


def test_as_a_table_it_has_a_row_for_every_cell(found: hb.Landscape):
    table = found.to_dataframe()
    assert table.columns == ["row", "column", "bits"]
    assert len(table) == 12
    assert table["bits"].null_count() == 3
    for row, column, bits in table.drop_nulls().iter_rows():
        assert bits == found.values[row, column]


@pytest.mark.parametrize("suffix", SUFFIXES)
def test_it_is_saved_by_the_files_suffix(found: hb.Landscape, suffix: str, tmp_path: Path):
    path, again = tmp_path / f"one{suffix}", tmp_path / f"two{suffix.upper()}"
    found.save(path)
    found.save(again)
    assert path.read_bytes() == again.read_bytes()
    flat = found.values.ravel()
    if suffix == ".png":
        with Image.open(path) as picture:
            assert picture.size > (3 * 48, 4 * 48)
    elif suffix == ".npy":
        np.testing.assert_array_equal(np.load(path), found.values)
    elif suffix == ".npz":
        with np.load(path) as arrays:
            np.testing.assert_array_equal(arrays["bits"], flat)
            np.testing.assert_array_equal(arrays["row"], np.arange(12) // 3)
    elif suffix in (".csv", ".parquet"):
        table = pl.read_csv(path) if suffix == ".csv" else pl.read_parquet(path)
        np.testing.assert_array_equal(table["bits"].fill_null(np.nan), flat)
    else:
        assert path.read_bytes().startswith({".svg": b"<?xml", ".pdf": b"%PDF"}[suffix])


def test_another_suffix_is_refused_and_all_that_there_are_named(
    found: hb.Landscape, tmp_path: Path
):
    with pytest.raises(ValueError, match=r"unknown suffix '\.xls'") as caught:
        found.save(tmp_path / "room.xls")
    assert all(suffix in str(caught.value) for suffix in SUFFIXES)
    assert not list(tmp_path.iterdir())


def test_a_notebook_shows_it_and_a_large_one_not_larger_than_a_page(found: hb.Landscape):
    picture = found._repr_png_()
    assert picture.startswith(b"\x89PNG")
    world = replace(ROOM, height=200, width=300)
    large = replace(found, world=world, values=np.zeros((200, 300)))
    with Image.open(BytesIO(large._repr_png_())) as image:
        assert image.width < 1500


def test_measuring_does_not_import_matplotlib():
    code = "import habilis as hb, sys; hb.landscape(hb.load_world('yard'), 1)"
    code += "; sys.exit('matplotlib' in sys.modules or 'polars' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", code]).returncode == 0


# Maps too large for their table


@pytest.mark.parametrize("tool", ["picker", "broom", "none"])
@pytest.mark.parametrize("sensor", ["state", "object", "agent"])
@pytest.mark.parametrize("horizon", [0, 1, 3, 30])
def test_what_can_be_reached_has_the_values_of_the_whole_table(
    tool: str, sensor: str, horizon: int, monkeypatch: pytest.MonkeyPatch
):
    world = hb.World.parse("A...\nP#..\n.C..\n...G\n", "room").with_tool(tool)
    moves = [{}, {"object": (0, 3)}, {"object": (0, 0)}]
    if tool != "none":
        moves += [{"tool": (3, 1), "object": (0, 2)}, {"tool": (0, 0)}]
    whole = [hb.landscape(world, horizon, sensor, **moved) for moved in moves]
    monkeypatch.setattr(landscape_states, "_FEW", 0)
    monkeypatch.setattr(landscape_states, "_SHARE", 1)
    used = spied(monkeypatch)
    for moved, expected in zip(moves, whole, strict=True):
        found = hb.landscape(world, horizon, sensor, **moved)
        np.testing.assert_array_equal(found.values, expected.values)
        assert found.world == expected.world
        assert found.title == expected.title
    assert used == [True] * len(moves)
    slipping = hb.landscape(world, min(horizon, 3), sensor, slip=0.1)
    monkeypatch.undo()
    expected = hb.landscape(world, min(horizon, 3), sensor, slip=0.1)
    np.testing.assert_allclose(slipping.values, expected.values, atol=1e-6)


def spied(monkeypatch: pytest.MonkeyPatch) -> list[bool]:
    """Whether the reachable part sufficed, each time that it was tried."""
    used: list[bool] = []
    reached = landscape_states.reachable

    def spy(*asked):
        used.append(False)
        found = reached(*asked)
        used[-1] = True
        return found

    monkeypatch.setattr(landscape_states, "reachable", spy)
    return used


def test_where_nearly_everything_can_be_reached_the_whole_table_is_taken(
    monkeypatch: pytest.MonkeyPatch,
):
    expected = hb.landscape(ROOM, 9, "object")
    monkeypatch.setattr(landscape_states, "_FEW", 0)
    used = spied(monkeypatch)
    np.testing.assert_array_equal(hb.landscape(ROOM, 9, "object").values, expected.values)
    assert used == [False]


def large_map() -> str:
    rows = [["."] * 100 for _ in range(100)]
    for character, cell in zip("APCG", [(50, 50), (50, 51), (50, 52), (99, 99)], strict=True):
        rows[cell[0]][cell[1]] = character
    return "\n".join("".join(row) for row in rows)


def test_a_map_too_large_for_its_table_has_a_landscape(tmp_path: Path, capsys):
    world = hb.World.parse(large_map(), "large")
    with pytest.raises(ValueError, match="placements are more than"):
        hb.tabulate(world)
    found = hb.landscape(world, 3, "object")
    places = [
        {"agent": cell, "tool": (50, 51), "object": (50, 52)}
        for cell in [(50, 50), (49, 49), (0, 0)]
    ]
    bits = hb.empowerment(world, 3, "object", states=places)
    assert [found.values[place["agent"]] for place in places] == bits.tolist()
    assert np.isfinite(found.values).sum() == 100 * 100 - 2
    (tmp_path / "large.txt").write_text(large_map())
    out = tmp_path / "large.png"
    verb = ["landscape", str(tmp_path / "large.txt"), "--sensor", "object", "--horizon", "3"]
    assert main([*verb, "--out", str(out)]) == 0
    assert capsys.readouterr().out.count("\n") == 101
    assert out.exists()


@pytest.mark.parametrize(
    "moved",
    [{"tool": (50, 52)}, {"object": (50, 51)}, {"tool": (200, 0)}, {"object": (-1, 0)}],
)
def test_on_a_large_map_too_things_need_free_cells(moved: dict):
    with pytest.raises(ValueError, match="cell"):
        hb.landscape(hb.World.parse(large_map(), "large"), 1, "object", **moved)


def test_what_is_too_much_even_so_is_refused(monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr(landscape_states, "MAX_STATES", 10_500)
    with pytest.raises(ValueError, match="large: 9 actions reach more than 10,500 placements"):
        hb.landscape(hb.World.parse(large_map(), "large"), 9, "object")
