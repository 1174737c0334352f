import numpy as np
import pytest

from habilis.learning.train import train
from habilis.sweeps.tasks import BLOCK, run_task, run_tasks, tasks_of


def test_a_task_trains_the_runs_that_training_them_all_gives(config):
    run = train(config)
    outcomes = [outcome for task in tasks_of(config) for outcome in run_task(task)]
    assert [outcome.run for outcome in outcomes] == list(range(7))
    assert tuple(outcome.converged_at for outcome in outcomes) == run.converged_at
    for outcome in outcomes:
        returns = run.episodes.filter(run=outcome.run)["return"].to_numpy()
        assert outcome.episodes_had == len(returns) == 300
        assert outcome.final_return == pytest.approx(returns[-100:].mean())
        np.testing.assert_allclose(outcome.curve, returns.reshape(-1, BLOCK).mean(axis=1))
        assert outcome.best_return == run.best_return
        assert outcome.seconds > 0
    assert len({outcome.final_return for outcome in outcomes}) > 1


def test_a_name_stands_for_settings_map_and_runs(config, room, tmp_path):
    first, second = tasks_of(config)
    assert first.name != second.name
    assert tasks_of(config.changed(runs=12))[0].name == first.name
    assert tasks_of(config.changed(learning_rate=3e-3))[0].name != first.name
    whole = config.changed(intrinsic="object", beta=1, horizon=1)
    assert tasks_of(whole)[0].name == tasks_of(whole.changed(beta=1.0))[0].name
    before = room.read_text()
    try:
        room.write_text(before.replace("C.", "C#"))
        assert tasks_of(config)[0].name != first.name
    finally:
        room.write_text(before)


def test_tasks_trained_side_by_side_come_to_the_same(config):
    other = config.changed(intrinsic="object", horizon=1, beta=0.1)
    tasks = tasks_of(config) + tasks_of(other)
    together = {}
    run_tasks(tasks, lambda task, outcomes: together.setdefault(task.name, outcomes))
    assert len(together) == 4
    assert all(together[task.name] == run_task(task) for task in tasks)


def test_a_run_that_stops_being_finite_is_given_up_and_the_others_go_on(config):
    wild = config.changed(learning_rate=1e30, clip=1e30)
    tasks = tasks_of(wild) + tasks_of(config)
    together = {}
    run_tasks(tasks, lambda task, outcomes: together.setdefault(task.name, outcomes))
    gone = [o for task in tasks[:2] for o in together[task.name]]
    fine = [o for task in tasks[2:] for o in together[task.name]]
    assert not any(o.finite or o.converged_at is not None for o in gone)
    assert all(o.finite for o in fine)
    assert tuple(fine) == run_task(tasks[2]) + run_task(tasks[3])


def test_what_ended_in_the_same_stretch_as_one_was_given_up_is_finished_too(config):
    brief = config.changed(runs=2, steps=1)
    wild = config.changed(runs=3, learning_rate=1e30, clip=1e30)
    (first,), (second,) = tasks_of(brief), tasks_of(wild)
    together = {}
    run_tasks([first, second], lambda task, outcomes: together.setdefault(task.name, outcomes))
    assert together[first.name] == run_task(first)
    assert not any(outcome.finite for outcome in together[second.name])
