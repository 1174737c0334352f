import signal
import subprocess
import sys
import time

import polars as pl
import pytest

from habilis.cli import main
from habilis.sweeps.searches import best_point, search
from habilis.sweeps.spec import OBJECTIVES, Range, Search, Spec, read_spec
from habilis.sweeps.store import LAYOUT, results

SPEC = """
[config]
world = "{room}"
runs = 2
episodes = 200
episode_limit = 50
hidden = [8]
[search]
minimise = "shortfall"
trials = 6
at_once = 2
seed = {seed}
learning_rate = {{low = 1e-4, high = 1e-2, log = true}}
rollout = {{low = 4, high = 6}}
"intrinsic, horizon, beta" = [["none", 0, 0.0], ["object", 1, 0.1]]
"""


@pytest.fixture(scope="module")
def spec(room, tmp_path_factory):
    path = tmp_path_factory.mktemp("spec") / "search.toml"
    path.write_text(SPEC.format(room=room, seed=3))
    return path


@pytest.fixture(scope="module")
def whole(spec, tmp_path_factory):
    """The result of an undisturbed search."""
    folder = tmp_path_factory.mktemp("searches") / "whole"
    frame = search(read_spec(spec), folder)
    assert results(folder).equals(frame)
    return frame.drop("seconds")


def test_a_search_tries_different_points_within_its_ranges(whole):
    assert whole.height == 6 * 2
    points = whole.group_by("point", maintain_order=True).first()
    assert points["learning_rate"].n_unique() == 6
    assert points["learning_rate"].is_between(1e-4, 1e-2).all()
    assert points["rollout"].is_in([4, 5, 6]).all()
    together = set(points.select("intrinsic", "horizon", "beta").rows())
    assert together <= {("none", 0, 0.0), ("object", 1, 0.1)}


def test_a_killed_search_goes_on_as_it_would_have(spec, tmp_path, whole):
    folder = tmp_path / "killed"
    command = [sys.executable, "-m", "habilis", "sweep", str(spec), "--out", str(folder)]
    for count in (1, 3):
        with open(tmp_path / "said", "w") as said:
            process = subprocess.Popen([*command, "--resume"], stdout=said, stderr=said)
        while len(list((folder / LAYOUT.results).glob("[!.]*.npz"))) < count:
            assert process.poll() is None, (tmp_path / "said").read_text()
            time.sleep(0.005)
        process.kill()
        assert process.wait() == -signal.SIGKILL
    assert main([*command[3:], "--resume"]) == 0
    assert results(folder).drop("seconds").equals(whole)


def test_more_trials_are_reason_to_go_on_and_the_first_ones_stay(spec, tmp_path, whole):
    folder, text = tmp_path / "more", spec.read_text()
    few = tmp_path / "few.toml"
    few.write_text(text.replace("trials = 6", "trials = 3"))
    first = search(read_spec(few), folder)
    assert first.drop("seconds").equals(whole[:6])
    assert search(read_spec(spec), folder, resume=True).drop("seconds")[:6].equals(whole[:6])
    other = tmp_path / "other.toml"
    other.write_text(text.replace("seed = 3", "seed = 4"))
    with pytest.raises(ValueError, match="was started with another search"):
        search(read_spec(other), folder, resume=True)
    elsewhere = search(read_spec(other), tmp_path / "elsewhere")
    assert not set(elsewhere["learning_rate"]) & set(whole["learning_rate"])


def test_impossible_points_are_reported_and_left_out(room, tmp_path, capsys):
    shared = {"world": str(room), "runs": 1, "episodes": 50, "algorithm": "ppo", "hidden": [8]}
    space = {"minibatches": [4, 7]}
    spec = Spec(shared, ("minibatches",), (), Search(space, trials=6, seed=1))
    frame = search(spec, tmp_path / "search")
    assert set(frame["minibatches"]) == {4}
    reported = capsys.readouterr().err.splitlines()
    assert len(reported) == 6 - frame.height > 0
    assert all("is left out: at minibatches = 7: minibatches is 7" in line for line in reported)
    none = Spec(shared, ("minibatches",), (), Search({"minibatches": [7]}, trials=1))
    with pytest.raises(ValueError, match="no point of the search can be trained"):
        search(none, tmp_path / "none")


def test_later_rounds_learn_from_earlier_ones(monkeypatch, tmp_path, room):
    """Where small numbers are good and where large ones are, the same draws part ways."""
    shared = {"world": str(room), "runs": 1, "episodes": 1, "steps": 1, "hidden": [4]}
    tried = {}
    for name, sign in (("small", 1), ("large", -1)):
        monkeypatch.setitem(OBJECTIVES, name, lambda runs, s=sign: s * runs["learning_rate"][0])
        wanted = Search({"learning_rate": Range(1e-5, 1e-1, log=True)}, name, 30, 5, 0)
        frame = search(Spec(shared, ("learning_rate",), (), wanted), tmp_path / name)
        tried[name] = frame["learning_rate"].log10()
        best = tried[name].arg_min() if name == "small" else tried[name].arg_max()
        assert best_point(frame, name) == best
    assert tried["small"][:10].equals(tried["large"][:10])
    assert tried["small"][10:].mean() < tried["large"][10:].mean() - 1


def test_runs_over_budget_count_with_their_budget():
    frame = pl.DataFrame(
        {
            "point": [0, 0, 1, 1],
            "converged_at": [100, None, 300, 300],
            "episodes": [1000] * 4,
            "best_return": [-4.0] * 4,
            "final_return": [-5.0, float("nan"), -4.0, -4.0],
            "finite": [True, False, True, True],
            "episode_limit": [50] * 4,
        }
    )
    assert OBJECTIVES["mean_episodes"](frame[:2]) == 550
    assert OBJECTIVES["shortfall"](frame[:2]) == (1 + 46) / 2
    assert best_point(frame, "mean_episodes") == 1
