"""The paper's figures: scales and axes."""

import numpy as np
import pytest
from matplotlib.figure import Figure
from paces import write_pace
from reproductions import reproduction

from habilis.studies.axes import episodes_axis, returns_axis
from habilis.studies.pace.data import load_pace
from habilis.studies.reproduction import figures


@pytest.fixture(scope="module")
def results(tmp_path_factory):
    folder = tmp_path_factory.mktemp("figures")
    return reproduction(folder, load_pace(write_pace(folder / "pace")), scale=0.2).results


def test_the_two_panels_of_figure_4b_have_one_colour_scale_and_one_bar():
    figure = figures.figure_4b()
    maps = [
        next(mesh for mesh in ax.collections if mesh.get_array() is not None)
        for ax in figure.axes[:2]
    ]
    assert maps[0].get_clim() == maps[1].get_clim()
    assert len(figure.axes) == 3


def labels_of(axis):
    return [label for label in axis.get_ticklabels() if label.get_text()]


def overlapping(figure, labels):
    figure.draw_without_rendering()
    boxes = [label.get_window_extent() for label in labels if label.get_visible()]
    return any(a.overlaps(b) for i, a in enumerate(boxes) for b in boxes[i + 1 :])


def test_learning_curves_have_ticks_that_can_be_read(results):
    for one in (
        figures.figure_2(results["table1"]),
        figures.returns_figure(results["table1"]),
        figures.returns_figure(results["table2"]),
    ):
        one.draw_without_rendering()
        for ax in one.axes:
            x = labels_of(ax.xaxis)
            assert "1,000" in [label.get_text() for label in x]
            assert not any("^" in label.get_text() for label in x), "no powers of ten"
            assert "episodes" in ax.get_xlabel()
            assert not overlapping(one, x)
            assert not overlapping(one, labels_of(ax.yaxis))
        assert one.axes[0].get_ylabel()


@pytest.mark.parametrize(("low", "high"), [(100, 300), (100, 2_000), (300, 40_000), (100, 2e6)])
def test_episodes_have_several_ticks_with_separators_and_room_between(low, high):
    figure = Figure(figsize=(5, 4), dpi=96)
    ax = figure.subplots()
    episodes_axis(ax.xaxis, "episodes", low, high)
    figure.draw_without_rendering()
    texts = [label.get_text() for label in labels_of(ax.xaxis)]
    assert len(texts) >= 2
    assert texts == [f"{float(text.replace(',', '')):,.0f}" for text in texts]
    assert not overlapping(figure, labels_of(ax.xaxis))
    assert ax.get_xlim() == (low, high)


def test_returns_have_a_minus_sign_and_end_above_the_best():
    figure = Figure()
    ax = figure.subplots()
    ax.plot([1, 2], [-500, -14])
    returns_axis(ax, -14)
    figure.draw_without_rendering()
    texts = [label.get_text() for label in labels_of(ax.yaxis)]
    assert {"−500", "−100", "−20"} <= set(texts)
    assert -14 < ax.get_ylim()[1] < 0


def test_labels_of_figure_1_are_in_points_that_stay_readable_at_the_pages_width():
    figure = figures.figure_1()
    width = figure.get_figwidth() * 96
    assert width <= 1104, "not shrunk by the page"
    sizes = [ax.title.get_fontsize() for ax in figure.axes if ax.get_title()]
    sizes += [ax.yaxis.label.get_fontsize() for ax in figure.axes if ax.get_ylabel()]
    assert len(sizes) == 9 + 4
    assert min(map(float, sizes)) >= 10
    figure.draw_without_rendering()
    for ax in figure.axes:
        if ax.get_ylabel():
            panel, label = ax.get_window_extent(), ax.yaxis.label.get_window_extent()
            assert label.height < panel.height * 1.35


def test_a_curve_is_drawn_with_few_points_from_its_first_to_its_last():
    at = figures._spread(50_000)
    assert (at[0], at[-1]) == (0, 49_999)
    assert len(at) <= 1000
    assert (np.diff(at) > 0).all()
    assert figures._spread(0).tolist() == []
    assert figures._spread(1).tolist() == [0]
