"""Heat maps can be read: by everyone, at every size, on every colour."""

from dataclasses import replace

import numpy as np
import pytest
from labels import labels_on
from matplotlib.axes import Axes
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.colors import to_rgb
from matplotlib.figure import Figure
from matplotlib.text import Text

from habilis.worlds.pictures.heatmap import HEAT, SMALLEST, draw_heat
from habilis.worlds.world import World

ROOM = World.parse("#####G\n#.....\n#..AP.\n#....C\n", name="room")

# How the colour-blind see linear RGB (Machado, Oliveira and Fernandes 2009, severity 1).
SIGHT = {
    "all colours": np.eye(3),
    "protanopia": np.array(
        [
            [0.152286, 1.052583, -0.204868],
            [0.114503, 0.786281, 0.099216],
            [-0.003882, -0.048116, 1.051998],
        ]
    ),
    "deuteranopia": np.array(
        [
            [0.367322, 0.860646, -0.227968],
            [0.280085, 0.672501, 0.047413],
            [-0.011820, 0.042940, 0.968881],
        ]
    ),
    "tritanopia": np.array(
        [
            [1.255528, -0.076749, -0.178779],
            [-0.078411, 0.930809, 0.147602],
            [0.004733, 0.691367, 0.303900],
        ]
    ),
    "none, only light": np.tile([0.2126, 0.7152, 0.0722], (3, 1)),
}


def values_of(world: World) -> np.ndarray:
    """Values from 0 to 3, all different, NaN on walls, tool and can."""
    values = np.linspace(0, 3, world.height * world.width).reshape(world.height, world.width)
    for cell in {*world.walls, world.tool_cell, world.object}:
        values[cell] = np.nan
    return values


def labels_of(world: World, values: np.ndarray, **settings) -> list[Text]:
    ax = Figure().add_subplot()
    draw_heat(ax, world, values, **settings)
    return labels_on(ax)


def rendered(figure: Figure) -> np.ndarray:
    canvas = FigureCanvasAgg(figure)
    canvas.draw()
    return np.asarray(canvas.buffer_rgba()).copy()


def drawn(world: World, values: np.ndarray, inches: float = 5, **settings) -> np.ndarray:
    figure = Figure(figsize=(inches, inches))
    draw_heat(figure.add_axes((0, 0, 1, 1)), world, values, **settings)
    return rendered(figure)


def linear(rgb: np.ndarray) -> np.ndarray:
    return np.where(rgb <= 0.04045, rgb / 12.92, ((rgb + 0.055) / 1.055) ** 2.4)


def contrast(one: np.ndarray, other: np.ndarray) -> float:
    """The contrast ratio of two colours by WCAG 2: 1 for the same, 21 for black on white."""
    darker, lighter = sorted(float(linear(c) @ (0.2126, 0.7152, 0.0722)) for c in (one, other))
    return (lighter + 0.05) / (darker + 0.05)


def lab(light: np.ndarray) -> np.ndarray:
    """CIE L*a*b* of linear RGB."""
    to_xyz = np.array(
        [[0.4124, 0.3576, 0.1805], [0.2126, 0.7152, 0.0722], [0.0193, 0.1192, 0.9505]]
    )
    xyz = light @ to_xyz.T / to_xyz.sum(axis=1)
    f = np.where(xyz > (6 / 29) ** 3, np.cbrt(xyz), xyz / (3 * (6 / 29) ** 2) + 4 / 29)
    x, y, z = f.T
    return np.stack([116 * y - 16, 500 * (x - y), 200 * (y - z)], axis=1)


@pytest.mark.parametrize("sight", SIGHT)
def test_every_eye_sees_the_scale_in_order_and_its_steps_apart(sight: str):
    light = np.clip(linear(HEAT(np.linspace(0, 1, 101))[:, :3]) @ SIGHT[sight].T, 0, 1)
    seen = lab(light)
    assert (np.diff(seen[:, 0]) > 0).all()  # lighter is more, throughout
    steps = seen[::10]
    apart = np.linalg.norm(np.diff(steps, axis=0), axis=1)
    assert apart.min() > 5  # one is just noticeable at 2.3
    distance = np.linalg.norm(steps - steps[:, None], axis=2)
    assert (np.diff(distance[0]) > 0).all()


def test_there_is_a_label_for_every_value():
    values = values_of(ROOM)
    labels = labels_of(ROOM, values)
    assert len(labels) == np.isfinite(values).sum()
    assert {label.get_text() for label in labels} >= {"1.8", "2.9"}
    assert labels_of(ROOM, values, labels=False) == []


def test_values_that_differ_little_have_two_decimals_which_fit_their_cells():
    values = values_of(ROOM) / 10
    figure = Figure()
    ax = figure.add_subplot()
    draw_heat(ax, ROOM, values)
    expected = {f"{value:.2f}" for value in values[np.isfinite(values)]}
    assert {label.get_text() for label in labels_on(ax)} == expected
    assert all(width < 1 for width, _ in ink_boxes(figure, ax))


def test_a_value_a_little_below_zero_is_not_printed_as_minus_zero():
    values = np.where(np.isfinite(values_of(ROOM)), -1e-12, np.nan)
    assert {label.get_text() for label in labels_of(ROOM, values)} == {"0.0"}


def test_labels_can_be_read_on_every_colour_of_the_scale():
    world = World.parse("A" + "CG.".rjust(299, "."), "strip")
    values = np.linspace(0, 1, 300)[None]
    ax = Figure().add_subplot()
    heat = draw_heat(ax, world, values)
    colours = heat.to_rgba(values)[0, :, :3]
    inks = set()
    for label in labels_on(ax):
        ink = label.get_color()
        inks.add(ink)
        column = int(label.get_position()[0])
        assert contrast(np.array(to_rgb(ink)), colours[column]) >= 4.5
    assert len(labels_on(ax)) == 300
    assert inks == {"black", "white"}


def ink_boxes(figure: Figure, ax: Axes) -> list[tuple[float, float]]:
    """How many cells across and high each label is, once drawn."""
    rendered(figure)
    cell = np.abs(ax.transData.transform((1, 1)) - ax.transData.transform((0, 0)))
    boxes = [label.get_window_extent() for label in labels_on(ax)]
    return [(box.width / cell[0], box.height / cell[1]) for box in boxes]


@pytest.mark.parametrize("change", ["figure", "dots", "layout", "zoom"])
def test_labels_follow_the_cells_whatever_becomes_of_the_axes(change: str):
    figure = Figure(figsize=(8, 6))
    ax = figure.add_axes((0, 0, 1, 1))
    draw_heat(ax, ROOM, np.full((4, 6), 12.3))
    before = ink_boxes(figure, ax)
    size = labels_on(ax)[0].get_fontsize()
    if change == "figure":
        figure.set_size_inches(4, 3)
    elif change == "dots":
        figure.set_dpi(200)
    elif change == "layout":
        ax.set_position((0.2, 0.2, 0.5, 0.5))
    else:
        ax.set_xlim(1, 4)
        ax.set_ylim(3, 1)
    np.testing.assert_allclose(ink_boxes(figure, ax), before, rtol=0.1)  # whole pixels
    part = {"figure": 0.5, "dots": 1, "layout": 0.5, "zoom": 2}[change]
    assert labels_on(ax)[0].get_fontsize() == pytest.approx(part * size)
    assert max(width for width, _ in before) < 0.95


@pytest.mark.parametrize(("cell", "printed"), [(16, False), (28, False), (32, True), (80, True)])
def test_no_label_is_printed_that_is_too_small_to_read(cell: int, printed: bool):
    values = values_of(ROOM)
    labelled, bare = (drawn(ROOM, values, cell * 6 / 100, labels=on) for on in (True, False))
    row = np.s_[2 * cell : 3 * cell, cell : 6 * cell]  # without things
    assert (labelled[row] != bare[row]).any() == printed


def test_a_large_map_has_no_labels_to_lay_out():
    world = replace(ROOM, height=100, width=100)
    figure = Figure(figsize=(4, 4))
    ax = figure.add_subplot()
    draw_heat(ax, world, np.zeros((100, 100)))
    rendered(figure)
    assert all("texts" not in vars(artist) for artist in ax.artists)


def test_zoomed_in_no_label_is_printed_outside_the_axes():
    figure = Figure(figsize=(4, 4))
    ax = figure.add_axes((0.4, 0.4, 0.2, 0.2))
    draw_heat(ax, ROOM, np.full((4, 6), 1.0))
    ax.set(xlim=(1, 3), ylim=(3, 1))
    outside = rendered(figure)
    outside[158:242, 158:242] = 255
    assert (outside == 255).all()


def test_the_agent_is_drawn_only_if_asked_for():
    values = values_of(ROOM)
    elsewhere = ROOM.with_cells(agent=(1, 1))
    assert (drawn(ROOM, values) == drawn(elsewhere, values)).all()
    assert (drawn(ROOM, values, agent=True) != drawn(elsewhere, values, agent=True)).any()


def test_bin_can_and_tool_are_drawn():
    values = values_of(ROOM)
    plain = drawn(ROOM, values)
    others = [ROOM.with_tool(tool) for tool in ("broom", "none")]
    others += [ROOM.with_cells(goal=(1, 1)), ROOM.with_cells(object=(1, 1))]
    for other in others:
        assert (plain != drawn(other, values)).any(), other


@pytest.mark.parametrize("value", [0.0, 2.5, np.nan])
def test_values_without_differences_have_a_scale(value: float):
    heat = draw_heat(Figure().add_subplot(), ROOM, np.full((4, 6), value))
    low, high = heat.get_clim()
    assert low == np.nan_to_num(value)
    assert high is not None
    assert high > low


def test_a_long_title_is_no_wider_than_the_map_while_it_can_be_read():
    figure = Figure(figsize=(4, 4))
    ax = figure.add_subplot()
    draw_heat(ax, ROOM, values_of(ROOM), title="6-step empowerment, sensor 'object'")
    rendered(figure)
    assert ax.title.get_window_extent().width < 1.05 * ax.get_window_extent().width
    assert SMALLEST <= float(ax.title.get_fontsize()) < 12
    draw_heat(ax, ROOM, values_of(ROOM), title="short")
    assert ax.title.get_fontsize() == 12


def test_values_of_another_shape_are_refused():
    with pytest.raises(ValueError, match=r"room: .*4 rows and 6 columns.*\(6, 4\)"):
        draw_heat(Figure().add_subplot(), ROOM, np.zeros((6, 4)))
