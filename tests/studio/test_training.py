"""The studio trains with the real trainer, and shows what was learned."""

import asyncio
import contextlib
import os
import signal
import time
from pathlib import Path

import msgspec
import numpy as np
import pytest

import habilis as hb
from habilis.learning.config import Config
from habilis.learning.curves import learning_curve
from habilis.learning.folder import load_run, save_run
from habilis.learning.replay import learned, play
from habilis.learning.runner import train
from habilis.studio import run_steps, training_jobs
from habilis.studio.drawn_worlds import world_of
from habilis.studio.limits import TRAINING
from habilis.studio.protocol.scenes import Drawn
from habilis.studio.training_jobs import Training
from habilis.worlds.plans import solve
from habilis.worlds.table import placement
from habilis.worlds.tools import TOOLS
from studio import page, printing_rake, scene, studio

SMALL = hb.World.parse("A...\nP.C.\n...G\n....", "small")
SETTINGS = {"intrinsic": "object", "horizon": 2, "beta": 0.1, "runs": 2, "episodes": 400, "seed": 3}
# To whom standing near the can is worth more than the goal, it does not converge.
ENDLESS = {"intrinsic": "object", "horizon": 3, "beta": 10, "runs": 10, "episodes": 100_000}
needs_proc = pytest.mark.skipif(not Path("/proc/self").exists(), reason="needs /proc")
LONG = {"runs": 1, "algorithm": "soft-value-iteration", "episodes": 100_000, "discount": 0.0}


@pytest.fixture(scope="module")
def run(tmp_path_factory):
    """The same training, without the studio."""
    path = tmp_path_factory.mktemp("run") / "small.txt"
    path.write_text(SMALL.text())
    return train(hb.Config.from_dict(SETTINGS | {"world": str(path)}))


@pytest.fixture(scope="module")
def address(run, tmp_path_factory):
    folder = tmp_path_factory.mktemp("trained") / "toe"
    save_run(run, folder)
    with studio(str(folder)) as address:
        yield address


def done(there, number):
    """All that a training tells."""
    answers = []
    for answer in there.answers(number):
        answers.append(answer)
        if "done" in answer or "error" in answer:
            return answers
    raise AssertionError


def check_view(there, run, **which):
    """That a view of run 1 shows what the library says."""
    view = there.ask("run", index=1, **which)
    episode, mdp = play(run, 1), hb.tabulate(run.map)
    policy, values = learned(run, mdp, 1)
    assert view["episode"]["actions"] == list(episode.actions)
    assert view["episode"]["return"] == episode.episode_return
    places = [placement(run.map, mdp, state) for state in episode.states]
    assert [tuple(p["agent"]) for p in view["episode"]["placements"]] == [p.agent for p in places]
    assert np.allclose(view["policy"]["episode"], policy[list(episode.states)], rtol=1e-4)
    assert np.allclose(np.sum(view["policy"]["episode"], axis=1), 1, atol=1e-3)
    assert SMALL.tool_cell is not None
    here = mdp.find(agent=(3, 3), tool=SMALL.tool_cell, object=SMALL.object)
    assert np.allclose(view["policy"]["cells"][3][3], policy[here], rtol=1e-4)
    assert view["values"][3][3] == pytest.approx(float(values[here]), rel=1e-4)
    assert view["values"][SMALL.object[0]][SMALL.object[1]] is None
    assert view["curve"]["mean"][-1] == pytest.approx(learning_curve(run).middle[-1], rel=1e-4)


def test_a_trained_run_is_shown_as_the_library_has_it(there, run):
    assert there.hello["run"]["name"] == "toe"
    assert there.hello["run"]["config"]["beta"] == 0.1
    assert (
        world_of(msgspec.convert(there.hello["run"]["drawn"], Drawn), TOOLS, "toe").object
        == SMALL.object
    )
    check_view(there, run)


def test_a_view_has_in_hand_what_can_be_put_down(tmp_path):
    (tmp_path / "map.txt").write_text("drop: true\nAP..\n.C.G\n....\n....\n")
    config = hb.Config(world=str(tmp_path / "map.txt"), runs=1, episodes=2)
    run = hb.train(config, out=tmp_path / "run")
    mdp = hb.tabulate(run.map)
    values = learned(run, mdp, 0)[1]
    put_down = int(mdp.next_state[mdp.start, mdp.actions.index("drop")])
    assert values[put_down] != values[mdp.start]
    view = run_steps.view(str(tmp_path / "run"), 0)
    assert view["values"][0][0] == pytest.approx(float(values[mdp.start]), rel=1e-4)


def test_a_view_is_of_any_place_of_the_things(there, run):
    mdp = hb.tabulate(run.map)
    at = {"agent": [0, 0], "tools": [[0, 1]], "objects": [[2, 2]]}
    view = there.ask("run", index=0, placement=at)
    values = learned(run, mdp, 0)[1]
    state = mdp.find(agent=(0, 0), tool=(0, 1), object=(2, 2))
    assert view["values"][0][0] == pytest.approx(float(values[state]), rel=1e-4)
    assert view["values"][3][3] is None  # nobody holds the tool from there
    episode = play(run, 0, state)
    assert view["episode"]["actions"] == list(episode.actions)
    assert view["episode"]["placements"][0] == at
    best = solve(mdp, state)
    assert best is not None
    assert view["episode"]["best_return"] == best.best_return
    at["objects"] = [[0, 1]]
    refusal = there.ask("run", index=0, placement=at)["error"]
    assert refusal.startswith("a placement has two things in one cell")


def test_a_run_that_is_not_there_is_refused(there):
    assert there.ask("run", index=2)["error"] == "run is 2; use 0 to 1"
    assert "no training has the name" in there.ask("run", index=0, name="x")["error"]


def test_training_from_the_page_is_the_trainers(there, run):
    answers = done(there, there.send("train", scene=scene(SMALL), settings=SETTINGS))
    end = answers[-1]
    assert end["done"]["converged_at"] == list(run.converged_at)
    assert end["episodes"] == len(run.episodes)
    assert end["steps"] == run.episodes["steps"].sum()
    check_view(there, run, name=end["done"]["name"])
    with page("http://" + there.socket.request.headers["Host"] + "/") as other:
        assert "error" in other.ask("run", index=0, name="0" * 8)


def test_curves_stream_while_it_trains_and_stop_keeps_what_there_is(there):
    number = there.send("train", scene=scene(SMALL), settings=LONG)
    curves = []
    for answer in there.answers(number):
        assert "done" not in answer
        if answer.get("curve"):
            curves.append(answer["curve"])
        if len(curves) == 2:
            break
    assert len(curves[1]["x"]) > 1
    assert curves[1]["x"][-1] > curves[0]["x"][-1]
    there.socket.send(f'{{"id": {number}, "do": "stop"}}')
    end = done(there, number)[-1]
    assert end["done"]["converged_at"] == [None]
    assert 0 < end["episodes"] < 100_000
    view = there.ask("run", index=0, name=end["done"]["name"])
    assert view["episodes"] == end["episodes"]
    assert "no training has the id" in there.ask("stop")["error"]


def test_a_page_trains_one_thing_at_a_time_and_measures_meanwhile(there):
    number = there.send("train", scene=scene(SMALL), settings=LONG)
    assert "stop it first" in there.ask("train", scene=scene(SMALL), settings={})["error"]
    assert "landscape" in there.ask("measure", scene=scene(SMALL))
    there.socket.send(f'{{"id": {number}, "do": "stop"}}')
    done(there, number)


@pytest.mark.parametrize(
    ("settings", "words"),
    [
        ({"runs": 11}, "runs is 11; give a whole number from 1 to 10"),
        ({"horizon": 11, "intrinsic": "object", "beta": 1.0}, "horizon is 11; give a whole number"),
        ({"episodes": 10**6}, "give a whole number from 1 to 100,000"),
        ({"hidden": [60_000]}, "settings has 'hidden', which is unknown"),
        ({"world": "/etc/passwd"}, "settings has 'world', which is unknown"),
        ({"algorithm": "dqn"}, "algorithm 'dqn' is unknown"),
        ({"intrinsic": "object"}, "give both the reward and its weight, or neither"),
        ({"beta": "much"}, "beta is 'much'; give a finite number"),
        ({"intrinsic": "smell", "beta": 1.0, "horizon": 1}, "'smell' is unknown"),
    ],
)
def test_invalid_settings_get_the_trainers_error(there, settings, words):
    answers = done(there, there.send("train", scene=scene(SMALL), settings=settings))
    assert words in answers[-1]["error"]


def test_training_uses_the_noise_that_is_measured(there, tmp_path):
    failing = hb.World.parse("P = picker slip 0.3\n" + "\n".join(SMALL.rows), "small")
    (tmp_path / "small.txt").write_text(failing.text())
    settings = {"algorithm": "soft-value-iteration", "runs": 1, "episodes": 20_000}
    asked = there.send("train", scene=scene(failing, slip=0.1), settings=settings)
    end = done(there, asked)[-1]
    world = str(tmp_path / "small.txt")
    run = train(hb.Config.from_dict(settings | {"world": world, "slip": 0.1}))
    assert end["done"]["converged_at"] == list(run.converged_at)
    assert None not in run.converged_at
    view = there.ask("run", index=0, name=end["done"]["name"])
    assert view["episode"]["actions"] == list(play(run).actions)
    assert view["episode"]["best_return"] == pytest.approx(run.best_return)


def test_what_would_take_too_long_or_has_no_goal_is_not_trained(there):
    large = hb.World.parse("\n".join(["AP.CG" + "." * 25] + ["." * 30] * 29))
    assert (
        "placements; train on at most"
        in there.ask("train", scene=scene(large), settings={})["error"]
    )
    walled = hb.World.parse("AC#G\n..##\n....\n....")
    answers = done(there, there.send("train", scene=scene(walled), settings={"runs": 1}))
    assert "the goal cannot be reached" in answers[-1]["error"]


def test_tools_that_can_be_put_down_do_not_get_past_the_limit_of_placements(there):
    above = "R = rake\nS = stick\ndrop: true\nA.P.R.S.C.\n"
    text = above + "..........\n" * 5 + ".........G"
    answers = done(there, there.send("train", scene={"map": text}, settings={"runs": 1}))
    assert "make more than 400,000 placements" in answers[-1]["error"]


@needs_proc
def test_a_trainer_that_dies_is_no_training_that_has_ended(there):
    number = there.send("train", scene=scene(SMALL), settings=LONG)
    answers = there.answers(number)
    next(answer for answer in answers if answer.get("curve"))
    for process in trainers_of(os.getpid()):
        os.kill(process, signal.SIGKILL)
    error = next(answer for answer in answers if "done" in answer or "error" in answer)["error"]
    assert error.startswith("the trainer ended unexpectedly")
    assert "landscape" in there.ask("measure", scene=scene(SMALL))


@needs_proc
def test_closing_a_page_ends_what_it_trains(address):
    stuck = 300  # seconds after which what has not come is not going to
    for _ in range(TRAINING["at_once"]):
        with page(address) as leaving:
            yard = scene(hb.load_world("yard"))
            answers = leaving.answers(leaving.send("train", scene=yard, settings=ENDLESS))
            next(answer for answer in answers if answer.get("curve"))
    began = time.monotonic()
    while trainers_of(os.getpid()) and time.monotonic() - began < stuck:
        time.sleep(0.1)
    assert not trainers_of(os.getpid())


def test_a_training_goes_on_on_a_page_that_is_loaded_again(address):
    with page(address) as leaving:
        answers = leaving.answers(leaving.send("train", scene=scene(SMALL), settings=LONG))
        name = next(answers)["name"]
        before = next(answer for answer in answers if answer.get("curve"))
    with page(address) as back:
        number = back.send("follow", name=name)
        answers = back.answers(number)
        assert next(answers)["name"] == name
        after = next(one for one in answers if one.get("episodes", 0) > before["episodes"])
        assert "stop it first" in back.ask("follow", name=name)["error"]
        back.socket.send(f'{{"id": {number}, "do": "stop"}}')
        end = done(back, number)[-1]
        assert end["done"]["name"] == name
        assert end["episodes"] >= after["episodes"]
        assert "under way" in back.ask("follow", name=name)["error"]


@needs_proc
def test_trainings_wait_for_each_other_but_not_all_that_are_asked_for():
    yard = scene(hb.load_world("yard"))
    allowed = TRAINING["at_once"] + TRAINING["waiting"]
    # A studio of its own: in another one, trainings of pages that have just gone still count.
    with studio() as address, contextlib.ExitStack() as pages:
        for _ in range(allowed):
            one = pages.enter_context(page(address))
            number = one.send("train", scene=yard, settings=ENDLESS)
            assert "progress" in next(one.answers(number))
        last = pages.enter_context(page(address))
        answer = next(last.answers(last.send("train", scene=yard, settings=ENDLESS)))
        wanted = f"{TRAINING['waiting']} trainings are queued already; try again later"
        assert answer.get("error") == wanted
        assert len(trainers_of(os.getpid())) <= TRAINING["at_once"]


def trainers_of(process: int) -> list[int]:
    """The trainers among the processes that a process has started, and those that these have."""
    found = []
    for children in Path(f"/proc/{process}/task").glob("*/children"):
        with contextlib.suppress(FileNotFoundError, ProcessLookupError):  # it has just ended
            for child in map(int, children.read_text().split()):
                words = Path(f"/proc/{child}/cmdline").read_bytes().split(b"\0")
                found += [child] * (b"habilis.studio.training_process" in words) + trainers_of(
                    child
                )
    return found


def test_a_tool_of_ones_own_that_prints_trains_as_others_do(tmp_path):
    with studio("--tool", printing_rake(tmp_path)) as address, page(address) as there:
        asked = scene(SMALL.with_tool(f"{tmp_path}/mine.py:Rake"))
        answers = done(there, there.send("train", scene=asked, settings=SETTINGS))
    assert answers[-1]["episodes"] > 0, answers[-1]


def test_what_is_trained_is_kept_where_it_was_asked_to_be(run, tmp_path):
    kept = tmp_path / "a" / "kept"
    walled = hb.World.parse("AC#G\n..##\n....\n....")
    with studio("--out", str(kept)) as address, page(address) as there:
        assert there.hello["kept"] == str(kept)
        refused = done(there, there.send("train", scene=scene(walled), settings={"runs": 1}))
        assert "the goal cannot be reached" in refused[-1]["error"]
        end = done(there, there.send("train", scene=scene(SMALL), settings=SETTINGS))[-1]
    name = end["done"]["name"]
    assert {path.name for path in kept.iterdir()} == {name, f"{name}.txt"}
    assert load_run(kept / name).episodes.equals(run.episodes)
    with studio(str(kept / name)) as address, page(address) as there:
        assert there.hello["kept"] is None
        assert there.hello["run"]["name"] == name
        check_view(there, run)


def test_a_training_stops_once_nobody_follows_it_and_not_before(tmp_path, monkeypatch):
    monkeypatch.setattr(training_jobs, "RELOADED", 0.05)
    stopped = []

    async def followed_by_two_pages_in_turn():
        training = Training("name", tmp_path, Config(), asyncio.Semaphore(1))
        monkeypatch.setattr(training, "stop", lambda: stopped.append("stopped"))
        training.report = {"share": 0.1}
        first, second = training.news(), training.news()
        for one in (first, second):
            assert await anext(one) == {"share": 0.1}
        await first.aclose()
        await asyncio.sleep(0.2)
        assert stopped == []
        await second.aclose()
        await asyncio.sleep(0.2)
        assert stopped == ["stopped"]
        training.ended = True
        third = training.news()
        assert await anext(third) == {"share": 0.1}
        await third.aclose()
        await asyncio.sleep(0.2)

    asyncio.run(followed_by_two_pages_in_turn())
    assert stopped == ["stopped"]
