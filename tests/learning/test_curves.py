"""Learning curves from episodes that are made up."""

import json
from dataclasses import replace

import numpy as np
import polars as pl
import pytest

from habilis.cli import main
from habilis.learning.algorithms.a2c import A2C
from habilis.learning.algorithms.ppo import PPO
from habilis.learning.config import Config
from habilis.learning.curves import learning_curve, smoothed
from habilis.learning.curves_picture import curves_figure, labels
from habilis.learning.folder import save_run
from habilis.learning.runner import train
from habilis.learning.runs import Run
from habilis.worlds.world import World

ROOM = "A.\nC.\n..\nG.\n"


def made_up(returns, converged, steps=None) -> Run:
    """A run of given returns, for each of its runs an array."""
    parts = [
        pl.DataFrame(
            {
                "run": np.full(len(one), k, np.int32),
                "episode": np.arange(len(one), dtype=np.int32),
                "steps": np.full(len(one), 4 if steps is None else steps[k], np.int32),
                "return": np.asarray(one, np.float32),
                "equipped": np.full(len(one), 2 * k, np.int32),
                "attached": np.full(len(one), k, np.int32),
            }
        )
        for k, one in enumerate(returns)
    ]
    config = Config(world="room", runs=len(returns))
    ends = tuple(len(r) if c else None for r, c in zip(returns, converged, strict=True))
    return Run(config, World.parse(ROOM, "room"), -1.0, pl.concat(parts), ends, None)


def test_a_smoothed_value_is_the_mean_of_the_last_ones():
    values = np.array([1.0, 3.0, np.nan, 5.0, 7.0])
    np.testing.assert_allclose(smoothed(values, 2), [1, 2, 3, 5, 6])
    assert np.isnan(smoothed(np.full(3, np.nan), 2)).all()


def test_a_run_that_converged_is_carried_on_so_that_the_mean_does_not_jump():
    early, late = np.full(300, -2.0), np.full(1_000, -10.0)
    curve = learning_curve(made_up([early, late], converged=[True, True]))
    assert curve.x[0] == 100
    assert curve.x[-1] == 1_000
    np.testing.assert_allclose(curve.middle, -6)
    assert curve.carried == 1
    np.testing.assert_allclose(curve.low, -10)
    np.testing.assert_allclose(curve.high, -2)


def test_a_run_that_has_not_converged_ends_the_curve():
    short, long = np.full(400, -50.0), np.full(1_000, -10.0)
    for converged in ([False, True], [False, False]):
        curve = learning_curve(made_up([short, long], converged))
        assert curve.x[-1] == 400
        np.testing.assert_allclose(curve.middle, -30)


def test_steps_of_the_environment_are_those_of_ended_episodes():
    slow, quick = np.arange(500.0), np.arange(500.0)
    curve = learning_curve(made_up([slow, quick], [False, True], steps=[20, 2]), unit="steps")
    assert (curve.x[0], curve.x[-1]) == (20 * 100, 20 * 500)
    assert curve.carried == 1
    assert curve.middle[-1] == pytest.approx(449.5)
    curve = learning_curve(made_up([slow, quick], [False, False], steps=[20, 2]), unit="steps")
    assert (curve.x[0], curve.x[-1]) == (20, 2 * 500)  # there the slow one has 50 episodes
    assert curve.middle[-1] == pytest.approx((24.5 + 449.5) / 2)


def test_the_interquartile_mean_leaves_out_the_run_that_fails():
    returns = [np.full(200, value) for value in (-500.0, -12.0, -12.0, -11.0)]
    run = made_up(returns, [False] * 4)
    assert learning_curve(run, statistic="iqm").middle[-1] == -12
    assert learning_curve(run).middle[-1] == pytest.approx(-133.75)


def test_shares_are_of_the_steps():
    run = made_up([np.zeros(200), np.zeros(200)], [True, True])
    assert learning_curve(run, "equipped").middle[-1] == 0.25  # none of one, half of the other
    assert learning_curve(run, "length").middle[-1] == 4
    with pytest.raises(ValueError, match="run 0 has no attached to plot yet"):
        learning_curve(run, "attached")


def test_a_run_without_an_episode_is_refused():
    with pytest.raises(ValueError, match="run 1 has no return to plot yet; train on"):
        learning_curve(made_up([np.zeros(5), np.zeros(0)], [False, False]))


def test_young_runs_are_drawn_from_where_all_have_an_episode():
    curve = learning_curve(made_up([np.arange(5.0), np.arange(800.0)], [False, False]))
    assert curve.x.tolist() == [1, 2, 3, 4, 5]
    np.testing.assert_allclose(curve.middle, [0, 0.5, 1, 1.5, 2])


def test_labels_name_what_differs_and_no_more():
    plain = Config()
    toe = plain.changed(intrinsic="object", horizon=6, beta=0.07)
    foe = toe.changed(intrinsic="state", horizon=5)
    names = ["a", "b", "c"]
    assert labels([plain, toe], names[:2]) == [
        "intrinsic none",
        "intrinsic object, horizon 6, beta 0.07",
    ]
    assert labels([toe, foe], names[:2]) == [
        "intrinsic object, horizon 6",
        "intrinsic state, horizon 5",
    ]
    assert labels([plain], ["runs/plain"]) == ["runs/plain"]
    assert labels([plain, plain], names[:2]) == ["a", "b"]
    others = [
        replace(plain, algorithm=a) for a in (A2C(), PPO(epochs=2, minibatches=1), PPO(epochs=3))
    ]
    assert labels(others, names) == [
        "a2c",
        "ppo, epochs 2, minibatches 1",
        f"ppo, epochs 3, minibatches {PPO().minibatches}",
    ]


def test_the_picture_has_a_line_and_a_band_for_each_and_the_best_return_dotted():
    curves = {
        name: learning_curve(made_up([np.full(300, value), np.full(200, value - 1)], [True, True]))
        for name, value in (("one", -5.0), ("two", -20.0))
    }
    (ax,) = curves_figure(curves, [-1.0, -1.0]).axes
    assert len(ax.collections) == 2
    drawn = [line for line in ax.lines if line.get_linestyle() != ":"]
    assert [line.get_label() for line in drawn] == ["one (2 runs)", "two (2 runs)"]
    assert len({line.get_color() for line in drawn}) == 2
    np.testing.assert_array_equal(drawn[1].get_ydata(), curves["two"].middle)
    assert sum(line.get_linestyle() == ":" for line in ax.lines) == 1
    assert ax.get_yscale() == "symlog"
    assert ax.get_title().startswith("mean over runs")


def test_a_curve_of_one_point_is_seen():
    curve = learning_curve(made_up([np.full(60, -5.0), np.full(60, -7.0)], [False, False]))
    (ax,) = curves_figure({"short": curve}).axes
    (line,) = ax.lines
    assert len(curve.x) == 1
    assert line.get_marker() == "o"


@pytest.fixture
def folders(tmp_path):
    (tmp_path / "room.txt").write_text(ROOM)
    config = Config(
        algorithm=A2C(hidden=(8,)), world=str(tmp_path / "room.txt"), runs=2, episodes=150
    )
    places = []
    for seed in (0, 1):
        places.append(str(tmp_path / f"seed {seed}"))
        save_run(train(config.changed(seed=seed)), places[-1])
    return places


def test_plot_draws_one_or_several_folders(folders, tmp_path, capsys, monkeypatch):
    for suffix, start in ((".png", b"\x89PNG"), (".svg", b"<?xml"), (".pdf", b"%PDF")):
        out = tmp_path / f"curves{suffix}"
        assert main(["plot", *folders, "--out", str(out), "--x", "steps"]) == 0
        assert out.read_bytes().startswith(start)
    assert "seed 0: mean return -" in capsys.readouterr().out
    assert main(["plot", *folders, "--json", "--statistic", "iqm", "--value", "length"]) == 0
    reported = json.loads(capsys.readouterr().out)
    assert [curve["label"] for curve in reported["curves"]] == ["seed 0", "seed 1"]
    assert reported["out"] is None
    for curve in reported["curves"]:
        assert curve["x"][-1] == 150
        ends = zip(curve["low"], curve["iqm"], curve["high"], strict=True)
        assert all(low <= middle <= high for low, middle, high in ends)
    monkeypatch.chdir(tmp_path)
    assert main(["plot", folders[0]]) == 0
    assert (tmp_path / "curves.png").exists()


def test_plot_refuses_what_it_cannot_draw(folders, tmp_path, capsys):
    (tmp_path / "file").write_text("no run")
    assert main(["plot", str(tmp_path / "nothing")]) == 2
    assert main(["plot", folders[0], folders[0]]) == 2
    assert main(["plot", str(tmp_path / "file")]) == 2
    said = capsys.readouterr().err
    assert "config.json: is missing" in said
    assert "is named twice; name each folder once" in said
    assert "file: is a file; name the folder of a run" in said
    assert main(["plot", folders[0], "--out", str(tmp_path / "curves.bmp")]) == 2
    assert "unknown suffix" in capsys.readouterr().err
    assert main(["plot", folders[0], "--value", "equipped", "--json"]) in (0, 2)
