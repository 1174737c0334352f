"""Steps in worker processes: served in turn, cancelled at any moment."""

import asyncio
import json
import subprocess
from pathlib import Path

import pytest

from habilis.studio.child_processes import command
from habilis.studio.clients import Client
from habilis.studio.pool import Pool, StepError

CLIENTS, STEPS = 50, 6


@pytest.fixture(autouse=True)
def _findable(monkeypatch):
    monkeypatch.syspath_prepend(Path(__file__).parents[1] / "support")
    monkeypatch.setenv("PYTHONPATH", str(Path(__file__).parents[1] / "support"), prepend=":")


def run(work, size=1, patience=0.1):
    async def whole():
        pool = Pool("studio_steps", size, patience)
        pool.start()
        try:
            return await work(pool)
        finally:
            await pool.close()

    return asyncio.run(whole())


async def unheard(message):
    pass


def test_every_client_gets_one_step_before_any_gets_two():
    served = []

    async def work(pool):
        async def ask(number):
            client = Client(unheard)
            for k in range(STEPS * 4 if number == 0 else STEPS):  # one wants more than all others
                served.append((await client.step(pool, "echo", value=number), k)[0])

        await asyncio.gather(*(ask(number) for number in range(CLIENTS)))

    run(work)
    for turn in range(STEPS):
        assert sorted(served[turn * CLIENTS : (turn + 1) * CLIENTS]) == list(range(CLIENTS))


@pytest.mark.parametrize("file", ["json.py", "numpy.py", "habilis.py"])
def test_a_file_in_the_working_directory_is_not_a_library(tmp_path, monkeypatch, file):
    (tmp_path / file).write_text("raise ImportError('not the one that is installed')")
    monkeypatch.chdir(tmp_path)
    assert run(lambda pool: pool.do(asyncio.Lock(), "echo", value="as ever")) == "as ever"
    done = subprocess.run(
        command("habilis.studio.training_process", str(tmp_path / "run")),
        input=json.dumps({"world": "nowhere"}),
        capture_output=True,
        text=True,
    )
    assert "nowhere" in json.loads(done.stdout)["error"]


def test_one_client_has_one_step_done_at_a_time_however_much_it_asks():
    async def work(pool):
        greedy, modest, order = Client(unheard), Client(unheard), []

        async def note(client, name):
            order.append(await client.step(pool, "echo", value=name))

        many = [asyncio.create_task(note(greedy, "greedy")) for _ in range(10)]
        await asyncio.sleep(0)
        await asyncio.gather(*many, note(modest, "modest"))
        return order

    assert run(work).index("modest") <= 1


def test_a_step_that_is_overtaken_and_never_ends_makes_way_for_the_next():
    async def work(pool):
        client = Client(unheard)
        endless = asyncio.create_task(client.step(pool, "forever"))
        await asyncio.sleep(0.5)
        endless.cancel()
        return await client.step(pool, "echo", value="next")

    assert run(work) == "next"


def test_a_step_that_is_overtaken_but_ends_at_once_leaves_its_process_alive():
    async def work(pool):
        client = Client(unheard)
        await client.step(pool, "echo", value=0)
        (before,) = pool.processes()
        quick = asyncio.create_task(client.step(pool, "echo", value=1))
        await asyncio.sleep(0)
        quick.cancel()
        assert await client.step(pool, "echo", value=2) == 2
        return before, pool.processes()

    before, after = run(work, patience=60)
    assert after == [before]


def test_a_process_that_dies_is_an_error_and_another_takes_its_place():
    async def work(pool):
        client = Client(unheard)
        with pytest.raises(StepError, match="ended unexpectedly"):
            await client.step(pool, "die")
        return await client.step(pool, "echo", value="again")

    assert run(work) == "again"


def test_an_error_of_a_step_is_reported_and_the_process_continues():
    async def work(pool):
        client = Client(unheard)
        with pytest.raises(StepError, match="two"):
            await client.step(pool, "fail")
        return await client.step(pool, "echo", value=1)

    assert run(work) == 1


def test_closing_ends_all_processes():
    async def work(pool):
        busy = [asyncio.create_task(Client(unheard).step(pool, "forever")) for _ in range(2)]
        await asyncio.sleep(0.5)
        processes = list(pool._all)
        await pool.close()
        for task in busy:
            task.cancel()
        await asyncio.gather(*busy, return_exceptions=True)
        return [process.returncode for process in processes]

    assert None not in run(work, size=2)


@pytest.mark.parametrize("moment", [0, 0.01, 0.1])
def test_closing_ends_processes_that_are_just_being_started(monkeypatch, moment):
    begun = []

    class Noted(subprocess.Popen):
        def __init__(self, *arguments, **options):
            super().__init__(*arguments, **options)
            begun.append(self)

    monkeypatch.setattr(subprocess, "Popen", Noted)

    async def work(pool):
        asked = asyncio.create_task(Client(unheard).step(pool, "forever"))
        await asyncio.sleep(moment)
        asked.cancel()
        await asyncio.gather(asked, return_exceptions=True)

    run(work, size=3)
    assert all(process.returncode is not None for process in begun)
    assert begun or not moment
