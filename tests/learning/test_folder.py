import jax
import numpy as np
import pytest

from habilis.files import check_unused
from habilis.learning.config import Config
from habilis.learning.folder import load_run, save_run
from habilis.learning.replay import greedy_actions, play
from habilis.learning.runner import train
from habilis.worlds.table import placement, tabulate


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    path = tmp_path_factory.mktemp("world") / "room.txt"
    path.write_text("A.\nC.\n..\nG.\n")
    config = Config(world=str(path), runs=2, episodes=6_000, episode_limit=50)
    return train(config.changed(hidden=(16,)))


@pytest.fixture
def folder(run, tmp_path):
    save_run(run, tmp_path / "run")
    return tmp_path / "run"


def test_a_run_is_read_back_as_it_was(run, folder):
    again = load_run(folder)
    assert again.config == run.config
    assert again.map.text() == run.map.text()
    assert again.episodes.equals(run.episodes)
    assert again.converged_at == run.converged_at
    assert again.best_return == run.best_return
    pairs = zip(jax.tree.leaves(run.parameters), jax.tree.leaves(again.parameters), strict=True)
    assert all(np.array_equal(a, b) for a, b in pairs)


@pytest.mark.parametrize(
    "name", ["config.json", "summary.json", "world.txt", "episodes.parquet", "parameters.npz"]
)
def test_a_damaged_or_missing_file_is_named(folder, name):
    (folder / name).write_bytes(b"{ not this")
    with pytest.raises(ValueError, match=f"{name}: is damaged .*train the run again") as error:
        load_run(folder)
    assert "\n" not in str(error.value)
    (folder / name).unlink()
    with pytest.raises(ValueError, match=f"{name}: is missing"):
        load_run(folder)


def test_a_file_cut_short_is_refused(folder):
    for name in ("episodes.parquet", "parameters.npz"):
        whole = (folder / name).read_bytes()
        (folder / name).write_bytes(whole[: len(whole) // 2])
        with pytest.raises(ValueError, match=f"{name}: is damaged"):
            load_run(folder)
        (folder / name).write_bytes(whole)


@pytest.mark.ill_typed
@pytest.mark.parametrize(
    ("name", "content", "says"),
    [
        ("summary.json", '{"converged_at": [1]}', "no entry for each of the 2 runs"),
        ("config.json", "[" * 100_000, "damaged"),
        ("parameters.npz", "", "damaged"),
        ("config.json", '{"runs": 2.5}', "runs is 2.5; give a whole number"),
    ],
)
def test_a_file_that_does_not_fit_is_named(folder, name, content, says):
    (folder / name).write_text(content)
    with pytest.raises(ValueError, match=f"{name}: .*{says}"):
        load_run(folder)


def test_parameters_that_are_not_finite_are_refused(run, folder):
    broken = jax.tree.map(lambda leaf: leaf * np.nan, run.parameters)
    (folder / "parameters.npz").unlink()
    leaves = jax.tree_util.tree_leaves_with_path(broken)
    arrays = {f"parameters{jax.tree_util.keystr(path)}": np.asarray(leaf) for path, leaf in leaves}
    np.savez(folder / "parameters.npz", allow_pickle=False, **arrays)
    with pytest.raises(ValueError, match="not finite"):
        load_run(folder)


def test_a_run_that_cannot_be_written_leaves_nothing(run, tmp_path, monkeypatch):
    def full(*_, **__):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(np, "savez", full)
    with pytest.raises(ValueError, match=r"cannot be written .*No space left"):
        save_run(run, tmp_path / "run")
    assert list(tmp_path.iterdir()) == []


def test_a_folder_in_use_is_refused_and_left_alone(run, folder):
    before = {path.name: path.read_bytes() for path in folder.iterdir()}
    with pytest.raises(ValueError, match="exists already"):
        save_run(run, folder)
    with pytest.raises(ValueError, match="exists already"):
        check_unused(folder)
    assert {path.name: path.read_bytes() for path in folder.iterdir()} == before


def test_a_file_in_the_place_of_the_folder_is_refused(run, tmp_path):
    (tmp_path / "file").write_text("")
    with pytest.raises(ValueError, match="is not a folder"):
        save_run(run, tmp_path / "file")


def test_a_place_below_a_file_is_refused_before_training(tmp_path):
    (tmp_path / "file").write_text("")
    with pytest.raises(ValueError, match="file is not a folder; name another place"):
        check_unused(tmp_path / "file" / "run")
    (tmp_path / "dangling").symlink_to(tmp_path / "nowhere")
    with pytest.raises(ValueError, match="is not a folder"):
        check_unused(tmp_path / "dangling")


def test_a_converged_run_plays_to_the_goal(run):
    assert run.converged_at[0] is not None
    episode = play(run, 0)
    assert episode.finished
    assert episode.episode_return == run.best_return
    mdp = tabulate(run.map)
    assert episode.states[0] == mdp.start
    for state, action, reached in zip(
        episode.states, episode.actions, episode.states[1:], strict=False
    ):
        assert mdp.next_state[state, action] == reached
        assert greedy_actions(run, mdp, 0)[state] == action


def test_a_policy_that_goes_round_in_circles_stops(run):
    still = jax.tree.map(np.zeros_like, run.parameters)  # always north: into the wall
    episode = play(type(run)(**{**vars(run), "parameters": still}), 0)
    assert not episode.finished
    assert len(episode.actions) == 1


def test_states_are_drawn_as_worlds(run):
    mdp = tabulate(run.map)
    frames = [placement(run.map, mdp, state) for state in play(run, 0).states]
    assert frames[0] == run.map
    assert frames[-1].object == run.map.goal


def test_a_run_that_is_not_there_is_refused(run):
    with pytest.raises(ValueError, match="run is 2; use 0 to 1"):
        play(run, 2)
