"""Trainings that have ended are found again: after a reload, and with --out after a restart."""

import json
import os
import shutil
from pathlib import Path

import pytest

import habilis as hb
from habilis.studio.limits import LISTED
from habilis.studio.training_jobs import Trainings
from studio import Page, page, scene, studio

SMALL = hb.World.parse("A...\nP.C.\n...G\n....", "small")
SETTINGS = {"intrinsic": "object", "horizon": 2, "beta": 0.1, "runs": 2, "episodes": 400, "seed": 3}
LONG = {"runs": 1, "algorithm": "soft-value-iteration", "episodes": 100_000, "discount": 0.0}
NAMES = (
    "",
    ".",
    "..",
    "x" * 300,
    "é" * 200,
    "a/b",
    "/etc",
    "..\\x",
    "a\nb",
    "\x00",
    "\ud800",
    "CON",
)


def listed(there: Page) -> list[dict]:
    """The server's list of the trainings that it has folders of."""
    answers = there.answers(there.send("trainings"))
    names = next(answers)["names"]
    return [next(answers)["kept"] for _ in names]


def trained(there: Page, settings: dict) -> dict:
    """The end of a training."""
    answers = there.answers(there.send("train", scene=scene(SMALL), settings=settings))
    return next(answer for answer in answers if "done" in answer)


@pytest.fixture(scope="module")
def kept(tmp_path_factory) -> tuple[Path, dict]:
    """A folder that a studio kept a training in, and the end of that training."""
    folder = tmp_path_factory.mktemp("studio") / "kept"
    with studio("--out", str(folder)) as address, page(address) as there:
        return folder, trained(there, SETTINGS)


def test_a_training_is_listed_again_by_the_next_studio_of_its_folder(kept):
    folder, end = kept
    name = end["done"]["name"]
    with studio("--out", str(folder)) as address, page(address) as there:
        (found,) = listed(there)
        assert found["name"] == name
        assert (found["ended"], found["under_way"], found["runs"]) == (True, False, 2)
        assert found["converged_at"] == end["done"]["converged_at"]
        assert found["best_return"] == end["done"]["best_return"]
        assert {key: found["config"][key] for key in SETTINGS} == SETTINGS
        assert there.ask("curve", name=name)["curve"] == end["curve"]
        assert there.ask("run", index=1, name=name)["drawn"] == found["drawn"]


def test_without_out_a_training_is_listed_on_every_page_while_the_studio_runs():
    with studio() as address:
        with page(address) as there:
            assert listed(there) == []
            name = trained(there, SETTINGS | {"episodes": 5})["done"]["name"]
        with page(address) as again:
            assert [one["name"] for one in listed(again)] == [name]


def test_a_training_of_another_page_is_listed_as_under_way_until_it_is_stopped():
    with studio() as address, page(address) as there, page(address) as other:
        number = there.send("train", scene=scene(SMALL), settings=LONG)
        answers = there.answers(number)
        next(answer for answer in answers if answer.get("curve"))
        (found,) = listed(other)
        assert (found["ended"], found["under_way"]) == (False, True)
        there.socket.send(json.dumps({"id": number, "do": "stop"}))
        next(answer for answer in answers if "done" in answer)
        (found,) = listed(other)
        assert (found["ended"], found["under_way"], found["converged_at"]) == (False, False, None)
        assert other.ask("run", index=0, name=found["name"])["episodes"] > 0


def test_folders_that_are_damaged_are_listed_with_what_is_wrong(kept, tmp_path):
    folder, end = kept
    whole = folder / end["done"]["name"]
    for name in ("config", "world", "summary", "endless", "begun", "a name\nin two lines"):
        shutil.copytree(whole, tmp_path / name)
    (tmp_path / "config" / "config.json").write_text("[")
    (tmp_path / "world" / "world.txt").write_text("no map")
    (tmp_path / "summary" / "summary.json").write_text('{"converged_at": 3}')
    (tmp_path / "endless" / "summary.json").write_text(
        '{"converged_at": [null, null], "best_return": NaN}'
    )
    (tmp_path / "begun" / "summary.json").unlink()
    # A folder without a run is ignored, damaged or not.
    (tmp_path / "photographs").mkdir()
    (tmp_path / ".hidden").mkdir()
    (tmp_path / "map.txt").write_text("AC.G")
    log = tmp_path / "errors.txt"
    with (
        log.open("w") as errors,
        studio("--out", str(tmp_path), stderr=errors) as address,
        page(address) as there,
    ):
        found = {one.pop("name"): one for one in listed(there)}
        assert there.ask("run", index=0, name="a name\nin two lines")["episodes"] > 0
    assert "config.json: is damaged" in found.pop("config")["error"]
    assert "world.txt: is damaged" in found.pop("world")["error"]
    assert "summary.json: is damaged" in found.pop("summary")["error"]
    assert "best_return is not a finite number" in found.pop("endless")["error"]
    assert "ended before its first checkpoint" in found.pop("begun")["error"]
    assert found.pop("a name\nin two lines")["ended"]
    assert not found
    assert log.read_text() == ""


@pytest.mark.parametrize("name", NAMES)
def test_a_name_that_is_none_is_one_line_of_error(tmp_path, name):
    (tmp_path / "run").mkdir()
    (tmp_path / "run" / "config.json").touch()
    (tmp_path / "config.json").touch()  # so that "." would have been one
    with pytest.raises(ValueError, match="no training has the name") as refused:
        Trainings(tmp_path).path(name)
    assert len(str(refused.value).splitlines()) == 1
    assert len(str(refused.value)) < 200
    assert Trainings(tmp_path).path("run") == tmp_path / "run"


def test_a_server_survives_every_such_name(kept, tmp_path):
    log = tmp_path / "errors.txt"
    with (
        log.open("w") as errors,
        studio("--out", str(kept[0]), stderr=errors) as address,
        page(address) as there,
    ):
        for name in NAMES:
            for asked in ({"do": "run", "index": 0}, {"do": "curve"}):
                error = there.ask(**asked, name=name)["error"]
                assert error.startswith(
                    "a message is not JSON (it has half of a surrogate pair)"
                    if name == "\ud800"
                    else "no training has the name"
                )
    assert log.read_text() == ""


def test_the_latest_trainings_are_listed_and_the_others_counted(tmp_path):
    for number in range(LISTED + 3):
        (tmp_path / f"run{number}").mkdir()
        (tmp_path / f"run{number}" / "config.json").touch()
    assert len(Trainings(tmp_path).names()) == LISTED + 3
    with studio("--out", str(tmp_path)) as address, page(address) as there:
        answer = next(there.answers(there.send("trainings")))
        assert (len(answer["names"]), answer["left_out"]) == (LISTED, 3)


def test_trainings_are_in_the_order_in_which_they_were_begun_the_latest_first(tmp_path):
    for name, began in (("old", 100), ("new", 300), ("between", 200)):
        (tmp_path / name).mkdir()
        (tmp_path / name / "config.json").touch()
        os.utime(tmp_path / name / "config.json", (began, began))
    assert Trainings(tmp_path).names() == ["new", "between", "old"]
    assert Trainings(tmp_path / "none").names() == []
    with pytest.raises(ValueError, match=r"config\.json: cannot be read"):
        Trainings(tmp_path / "old" / "config.json").names()
