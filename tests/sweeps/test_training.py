import numpy as np
import pytest

from habilis.learning.algorithms.ppo import PPO
from habilis.learning.config import Config
from habilis.learning.runner import train
from habilis.sweeps.training import BLOCK, outcomes, tasks_of, train_tasks


def trained(tasks):
    """The outcomes of tasks trained side by side, by their names."""
    together = {}
    train_tasks(tasks, together.__setitem__)
    return {name: comparable(result) for name, result in together.items()}


def comparable(result):
    """The outcomes of a task but for the time that it took, which differs."""
    return [{k: v for k, v in row.items() if k != "seconds"} for row in outcomes(result)]


def test_a_task_trains_the_runs_that_training_them_all_gives(config):
    run = train(config)
    found = [outcome for task in tasks_of(config) for outcome in outcomes(task.run())]
    assert [outcome["run"] for outcome in found] == list(range(7))
    assert tuple(outcome["converged_at"] for outcome in found) == run.converged_at
    for outcome in found:
        returns = run.episodes.filter(run=outcome["run"])["return"].to_numpy()
        assert outcome["episodes_had"] == len(returns) == 300
        assert outcome["final_return"] == pytest.approx(returns[-100:].mean())
        np.testing.assert_allclose(outcome["curve"], returns.reshape(-1, BLOCK).mean(axis=1))
        assert outcome["best_return"] == run.best_return
        assert outcome["seconds"] > 0
    assert len({outcome["final_return"] for outcome in found}) > 1


def test_a_name_stands_for_settings_map_runs_and_measures(config, room):
    first, second = tasks_of(config)
    assert first.name != second.name
    assert tasks_of(config.changed(runs=12))[0].name == first.name
    assert tasks_of(config.changed(learning_rate=3e-3))[0].name != first.name
    assert tasks_of(config, measures=(last_steps,))[0].name != first.name
    whole = config.changed(intrinsic="object", beta=1, horizon=1)
    assert tasks_of(whole)[0].name == tasks_of(whole.changed(beta=1.0))[0].name
    before = room.read_text()
    try:
        room.write_text(before.replace("C.", "C#"))
        assert tasks_of(config)[0].name != first.name
    finally:
        room.write_text(before)


def test_names_are_those_of_earlier_versions_so_that_their_folders_resume():
    """The names were recorded before the engine of `habilis.tasks` was there."""
    plain = tasks_of(Config(world="yard", runs=7))
    names = ["dec863698b6d5a700f8b8111126a9de9", "5714a4a14398c4f4ce1660b6d94e1c6e"]
    assert [task.name for task in plain] == names
    more = {"slip": 0.1, "starts": 4, "unseen": 2, "starts_seed": 3, "algorithm": PPO()}
    bonus = {"intrinsic": "object", "horizon": 2, "beta": 0.1}
    (task,) = tasks_of(Config(world="corridor", tool="broom", runs=1, **bonus, **more))
    assert task.name == "5d6abb0ba91cf97db72d23d93138de25"


def test_tasks_trained_side_by_side_come_to_the_same(config):
    other = config.changed(intrinsic="object", horizon=1, beta=0.1)
    tasks = tasks_of(config) + tasks_of(other)
    together = trained(tasks)
    assert len(together) == 4
    assert all(together[task.name] == comparable(task.run()) for task in tasks)


def test_a_run_that_diverges_ends_and_the_others_go_on(config):
    wild = config.changed(learning_rate=1e30, clip=1e30)
    tasks = tasks_of(wild) + tasks_of(config)
    together = trained(tasks)
    gone = [o for task in tasks[:2] for o in together[task.name]]
    fine = [o for task in tasks[2:] for o in together[task.name]]
    assert not any(o["finite"] or o["converged_at"] is not None for o in gone)
    assert all(o["finite"] for o in fine)
    assert fine == [o for task in tasks[2:] for o in comparable(task.run())]


def test_what_ended_in_the_same_stretch_as_one_diverged_is_finished_too(config):
    brief = config.changed(runs=2, steps=1)
    wild = config.changed(runs=3, learning_rate=1e30, clip=1e30)
    (first,), (second,) = tasks_of(brief), tasks_of(wild)
    together = trained([first, second])
    assert together[first.name] == comparable(first.run())
    assert not any(outcome["finite"] for outcome in together[second.name])


def last_steps(run, index):
    """A measure: the steps of the last episode, and of a tenth one, which no run has."""
    steps = run.episodes.filter(run=index)["steps"]
    return {"last": float(steps[-1]), "tenth": None}


def test_each_run_is_measured_where_it_is_trained(config):
    run = train(config)
    tasks = tasks_of(config, measures=(last_steps,))
    found = [outcome for task in tasks for outcome in outcomes(task.run())]
    for outcome in found:
        steps = run.episodes.filter(run=outcome["run"])["steps"]
        assert (outcome["last"], outcome["tenth"]) == (steps[-1], None)
    plain = [outcome for task in tasks_of(config) for outcome in comparable(task.run())]
    measured = ("last", "tenth", "seconds")
    assert [{k: v for k, v in o.items() if k not in measured} for o in found] == plain


def test_runs_that_diverge_are_not_measured(config):
    wild = config.changed(runs=2, learning_rate=1e30, clip=1e30)
    (task,) = tasks_of(wild, measures=(last_steps,))
    assert all(not row["finite"] and row.get("last") is None for row in outcomes(task.run()))
