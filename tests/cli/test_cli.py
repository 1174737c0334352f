"""The command line: what it prints, and how it refuses."""

import json
import re
import subprocess
import sys

import numpy as np
import polars as pl
import pytest
from video import read_mp4

import habilis as hb
from habilis.cli import main

VERBS = (
    *("worlds", "solve", "empowerment", "landscape", "futures", "compare"),
    *("train", "watch", "reproduce", "reconstruct", "studio", "bench"),
)


def run_json(capsys, *arguments):
    status = main([*arguments, "--json"])
    return status, json.loads(capsys.readouterr().out)


def test_worlds_lists_and_draws(capsys, tmp_path):
    assert run_json(capsys, "worlds") == (
        0,
        {"worlds": ["corridor", "corridor-b", "yard", "yard-b"]},
    )
    _, yard = run_json(capsys, "worlds", "yard", "--tool", "broom")
    assert yard["map"][3] == "B.#......."
    assert main(["worlds", "yard", "--out", str(tmp_path / "yard.png")]) == 0
    assert (tmp_path / "yard.png").read_bytes().startswith(b"\x89PNG")


def test_solve_prints_a_plan_that_works(capsys):
    status, plan = run_json(capsys, "solve", "corridor")
    assert (status, plan["steps"], plan["return"]) == (0, 15, -14)
    mdp = hb.tabulate(hb.load_world("corridor"))
    state = mdp.start
    for action in plan["actions"]:
        assert not mdp.terminal[state]
        state = mdp.next_state[state, action]
    assert mdp.terminal[state]
    assert run_json(capsys, "solve", "yard", "--tool", "broom")[1]["return"] == -12


def test_solve_of_a_goal_out_of_reach_is_nulls_and_exit_1(capsys, tmp_path):
    (tmp_path / "walled.txt").write_text("AC#G\n")
    status, plan = run_json(capsys, "solve", str(tmp_path / "walled.txt"))
    assert (status, plan) == (1, {"steps": None, "return": None, "actions": None})
    assert main(["solve", str(tmp_path / "walled.txt")]) == 1


def test_compare_gives_the_published_averages(capsys):
    _, found = run_json(capsys, "compare", "yard", "--tools", "picker,broom,none", "--horizon", "3")
    assert {k: round(v, 2) for k, v in found["averages"].items()} == {
        "picker": 0.52,
        "broom": 0.28,
        "none": 0.23,
    }
    main(["compare", "corridor", "--horizon", "6"])
    out = capsys.readouterr().out
    assert "useful" in out.splitlines()[1]
    assert "encumbers" in out.splitlines()[3]


def test_landscape_is_null_where_the_agent_cannot_be(capsys, tmp_path):
    picture = tmp_path / "landscape.png"
    arguments = ("landscape", "corridor", "--sensor", "object", "--horizon", "6")
    _, found = run_json(capsys, *arguments, "--out", str(picture))
    values = np.array(found["values"], float)
    expected = hb.landscape(hb.load_world("corridor"), 6, "object").values
    np.testing.assert_array_equal(values, expected)
    assert np.isnan(values[2, 0])
    assert picture.read_bytes().startswith(b"\x89PNG")


@pytest.mark.parametrize("suffix", ["csv", "parquet", "npz", "npy", "svg", "pdf"])
def test_landscape_writes_its_values_too(capsys, tmp_path, suffix):
    path = tmp_path / f"landscape.{suffix}"
    arguments = ("landscape", "corridor", "--sensor", "object", "--horizon", "2")
    _, found = run_json(capsys, *arguments, "--out", str(path), "--object-at", "6,3")
    values = np.array(found["values"], float)
    expected = tmp_path / f"expected.{suffix}"
    hb.landscape(hb.load_world("corridor"), 2, "object", object=(6, 3)).save(expected)
    assert path.read_bytes() == expected.read_bytes()
    if suffix == "npy":
        np.testing.assert_array_equal(np.load(path), values)


def test_landscape_with_the_can_elsewhere(capsys):
    arguments = ("landscape", "corridor", "--sensor", "object", "--horizon", "1")
    _, moved = run_json(capsys, *arguments, "--object-at", "0,4")
    values = np.array(moved["values"], float)
    assert values[0, 3] == 1
    assert np.isnan(values[0, 4])


@pytest.mark.parametrize("suffix", ["csv", "parquet", "npz"])
def test_empowerment_writes_every_state(capsys, tmp_path, suffix):
    path = tmp_path / f"bits.{suffix}"
    arguments = ("empowerment", "corridor", "--sensor", "object", "--horizon", "6")
    _, summary = run_json(capsys, *arguments, "--out", str(path))
    read = {"csv": pl.read_csv, "parquet": pl.read_parquet, "npz": lambda p: dict(np.load(p))}
    table = read[suffix](path)
    mdp = hb.tabulate(hb.load_world("corridor"))
    np.testing.assert_allclose(table["bits"], hb.empowerment(mdp, 6, "object"))
    np.testing.assert_array_equal(
        table["object_row"] * 10 + table["object_column"], mdp.factor("object")
    )
    assert summary["states"] == mdp.states
    assert round(summary["mean_equipped"], 4) == 1.3886


def test_empowerment_writes_its_values_as_an_array(tmp_path):
    path = tmp_path / "bits.npy"
    assert main(["empowerment", "yard", "--horizon", "1", "--out", str(path)]) == 0
    mdp = hb.tabulate(hb.load_world("yard"))
    np.testing.assert_array_equal(np.load(path), hb.empowerment(mdp, 1))


def test_empowerment_of_a_gymnasium_environment_is_certified(capsys):
    status, found = run_json(capsys, "empowerment", "gym:FrozenLake-v1", "--horizon", "3")
    assert (status, found["states"]) == (0, 16)
    assert found["mean"] == pytest.approx(0.4852, abs=1e-4)
    assert 0 < found["gap"] <= 1e-6
    sure = "gym:FrozenLake-v1?is_slippery=False&map_name=8x8"
    _, found = run_json(capsys, "empowerment", sure, "--horizon", "1")
    assert (found["states"], found["max"], found["gap"]) == (64, 2, 0)


def test_slip_lowers_empowerment_and_nats_are_fewer_than_bits(capsys, tmp_path):
    (tmp_path / "small.txt").write_text("A.C.\nP..G\n....\n")
    small = str(tmp_path / "small.txt")
    asked = ("compare", small, "--tools", "picker,none", "--horizon", "2")
    _, sure = run_json(capsys, *asked)
    _, noisy = run_json(capsys, *asked, "--slip", "0.2")
    _, nats = run_json(capsys, *asked, "--unit", "nats")
    for tool, bits in sure["averages"].items():
        assert noisy["averages"][tool] < bits
        assert nats["averages"][tool] == pytest.approx(bits * np.log(2))


def test_futures_are_what_the_picker_can_do_to_an_attached_can(capsys, tmp_path):
    beside = ("--agent-at", "8,5", "--tool-at", "8,4", "--horizon", "3", "--sensor", "object")
    picture = tmp_path / "futures.png"
    _, found = run_json(capsys, "futures", "yard", *beside, "--out", str(picture))
    assert found["empowerment"] == pytest.approx(np.log2(len(found["observations"])))
    assert sum(found["probability"]) == pytest.approx(1)
    assert picture.read_bytes().startswith(b"\x89PNG")
    mdp = hb.tabulate(hb.load_world("yard"))
    state = mdp.find(agent=(8, 5), tool=(8, 4), object=(8, 3))
    reached = set()
    for sequence in found["sequences"]:
        at = state
        for action in sequence:
            at = mdp.next_state[at, action]
        reached.add(int(mdp.factor("object")[at]))
    assert reached == set(found["observations"])


def test_actions_are_named_or_listed(capsys):
    means = {}
    for actions in ("all", "moves", "tool", "0,1,2,3"):
        arguments = ("empowerment", "yard", "--horizon", "2", "--sensor", "object")
        means[actions] = run_json(capsys, *arguments, "--actions", actions)[1]["mean"]
    assert means["moves"] == means["0,1,2,3"] < means["all"]
    assert means["tool"] < means["all"]


def test_train_watch_and_what_they_leave(capsys, tmp_path):
    (tmp_path / "room.txt").write_text("A.\nC.\n..\nG.\n")
    folder = tmp_path / "run"
    arguments = ["train", str(tmp_path / "room.txt"), "--runs", "1", "--episodes", "8000"]
    arguments += ["--episode-limit", "50", "--hidden", "16", "--out", str(folder)]
    status, summary = run_json(capsys, *arguments)
    assert (status, summary["runs"], summary["best_return"]) == (0, 1, -1)
    assert pl.read_parquet(folder / "episodes.parquet").height > 2_000
    (tmp_path / "room.txt").unlink()  # the folder has all that watching needs
    gif = tmp_path / "run.gif"
    mp4 = tmp_path / "run.mp4"
    status, episode = run_json(capsys, "watch", str(folder), "--gif", str(gif), "--mp4", str(mp4))
    assert (status, episode["finished"], episode["return"]) == (0, True, -1)
    assert gif.read_bytes().startswith(b"GIF8")
    assert len(read_mp4(mp4, 2 * 32, 4 * 32)) == episode["steps"] + 1 + 5
    assert main(["watch", str(folder), "--mp4", str(tmp_path / "run.mov")]) == 2
    assert ".mp4" in capsys.readouterr().err
    assert main(["watch", str(folder)]) == 0
    assert "the goal is reached" in capsys.readouterr().out
    before = sorted(folder.iterdir())
    (tmp_path / "room.txt").write_text("A.\nC.\n..\nG.\n")
    assert main(arguments) == 2
    assert "exists already" in capsys.readouterr().err
    assert sorted(folder.iterdir()) == before


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (["solve", "nowhere"], "nowhere: no such world"),
        (
            ["solve", "corridor", "--tool", "spoon"],
            "use one of picker, broom, rake, stick, magnet, none",
        ),
        (["compare", "yard", "--horizon", "-1"], "give a whole number from 0 up"),
        (["compare", "yard", "--horizon", "two"], "invalid int value: 'two'"),
        (["compare", "yard", "--tools", "", "--horizon", "1"], "no tools to compare"),
        (["landscape", "yard", "--horizon", "1", "--sensor", "smell"], "state, agent, tool"),
        (["landscape", "yard", "--horizon", "1", "--object-at", "0"], "--object-at"),
        (["landscape", "yard", "--horizon", "1", "--object-at", "1,0"], "distinct free cells"),
        (["landscape", "yard", "--horizon", "1", "--out", "f.bmp"], ".png, .svg, .pdf, .csv"),
        (["empowerment", "yard", "--horizon", "1", "--out", "f.txt"], ".csv, .parquet, .npz"),
        (["empowerment", "yard", "--horizon", "1", "--actions", "jump"], "all, moves, tool"),
        (["empowerment", "yard", "--horizon", "1", "--actions", "9"], "indices from 0 to 7"),
        (["empowerment", "yard", "--horizon", "1", "--actions", ""], "--actions '' is unknown"),
        (
            ["empowerment", "yard", "--horizon", "1", "--actions", "9" * 23],
            f"--actions has {'9' * 23}; use indices from 0 to 7",
        ),
        (["empowerment", "", "--horizon", "1"], "habilis: '': no such world"),
        (["landscape", "yard", "--horizon", "1", "--max-states", "3"], "landscape --help"),
        (["empowerment", "gym:No-v0", "--horizon", "1"], "No-v0"),
        (
            ["empowerment", "gym:FrozenLake-v1?is_slippery", "--horizon", "1"],
            "argument 'is_slippery' has no value",
        ),
        (
            ["empowerment", "gym:FrozenLake-v1?is_slippery=", "--horizon", "1"],
            "argument 'is_slippery' has no value",
        ),
        (["empowerment", "gym:FrozenLake-v1?=3", "--horizon", "1"], "'=3' has no name"),
        (
            ["empowerment", "gym:FrozenLake-v1?map_name=4x4&map_name=8x8", "--horizon", "1"],
            "argument 'map_name' is given twice",
        ),
        (["empowerment", "gym:FrozenLake-v1?map_name=9x9", "--horizon", "1"], "(KeyError: '9x9')"),
        (["sweep", "no.toml", "--out", "s"], "give the path of a TOML file with [config]"),
        (
            ["sweep", "gym:Taxi-v4", "--out", "s"],
            "it is a Gymnasium environment); give the path of a TOML file with [config]",
        ),
        (
            ["reconstruct", "gym:Taxi-v4"],
            "(it is a Gymnasium environment); name one of corridor, corridor-all, yard, yard-all, "
            "yard-apart, or the path of a TOML",
        ),
        (
            ["empowerment", "gym:CartPole-v1", "--horizon", "1", "--max-states", "99"],
            "gym:CartPole-v1: more than 99 states can be reached",
        ),
        (["empowerment", "yard", "--horizon", "1", "--max-states", "99"], "more than 99"),
        (["empowerment", "yard", "--horizon", "1", "--max-states", "0"], "more than 0"),
        (["empowerment", "gym:Taxi-v4", "--horizon", "1", "--max-states", "9"], "has 500 states"),
        (["empowerment", "gym:Taxi-v4", "--horizon", "1", "--tool", "broom"], "--tool"),
        (["empowerment", "gym:Taxi-v4", "--horizon", "1", "--sensor", "key"], "passenger"),
        (
            ["empowerment", "yard", "--horizon", "9", "--slip", "0.1", "--max-seconds", "1"],
            "horizon",
        ),
        (["compare", "yard", "--horizon", "1", "--slip", "1.5"], "give a probability"),
        (["compare", "yard", "--horizon", "1", "--unit", "dits"], "invalid choice: 'dits'"),
        (["futures", "yard", "--horizon", "1", "--agent-at", "2,2"], "put it on a free cell"),
        (["futures", "yard", "--horizon", "1", "--out", "f.png"], "a picture needs cells"),
        (["train", "yard", "--runs", "0", "--out", "run"], "runs is 0; give at least 1"),
        (["train", "yard", "--intrinsic", "smell", "--beta", "1", "--out", "run"], "smell"),
        (["train", "yard", "--intrinsic", "object", "--out", "run"], "give both the reward"),
        (["train", "yard", "--seed", "9" * 25, "--out", "run"], "give one below"),
        (["train", "yard", "--hidden", "a", "--out", "run"], "not a list of widths"),
        (["train", "yard", "--runs", "1", "--out", "x" * 300], "the name is too long"),
        (["reproduce", "--out", "x" * 300], "the name is too long"),
        (["worlds", "--tool", "broom"], "no world to draw"),
        (
            ["landscape", "yard", "--horizon", "1", "--tool-at", "a"],
            "'a' is not a cell; write row,column",
        ),
        (
            ["landscape", "yard", "--tool", "none", "--horizon", "1", "--tool-at", "0,5"],
            "has no tool here",
        ),
        (["solve", "/dev/zero"], "is not a file"),
        (["watch", "nothing-here"], "config.json: is missing"),
        (["bench", "sleep"], "benchmark 'sleep' is unknown"),
        (["fly"], "invalid choice: 'fly'"),
        ([], "required"),
    ],
)
def test_bad_input_is_one_line_exit_2_and_nothing_on_disk(
    arguments, says, capsys, tmp_path, monkeypatch
):
    monkeypatch.chdir(tmp_path)
    assert main(arguments) == 2
    out, err = capsys.readouterr()
    assert says in err
    assert err.count("\n") == 1
    assert out == ""
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("A.PC\n.G\n", "line 2, column 3: the row has 2 cells and the first row has 4; give all"),
        ("; a map\nA.PX\n", "line 2, column 4: unknown character 'X'; use one of"),
        ("AA.CG\n", "line 1, column 2: a second agent 'A', the first is at line 1, column 1"),
        ("A...G\n", "the map has no can; put one 'C' on a floor cell"),
        ("", "the map is empty"),
    ],
)
def test_a_malformed_map_is_refused_with_place_and_fix(text, says, capsys, tmp_path):
    (tmp_path / "map.txt").write_text(text)
    assert main(["solve", str(tmp_path / "map.txt")]) == 2
    assert says in capsys.readouterr().err


@pytest.mark.parametrize(
    ("verb", "says"),
    [
        (["sweep", "map.txt", "--out", "s"], "not a TOML file .*; give the path of a TOML file"),
        (["reconstruct", "map.txt"], r"not a TOML file .*; give one \[map\], and a \[\[number"),
    ],
)
def test_a_map_in_the_place_of_a_list_is_refused_with_what_the_verb_takes(
    verb, says, capsys, tmp_path, monkeypatch
):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "map.txt").write_text("A.C.\n...G\n")
    assert main(verb) == 2
    err = capsys.readouterr().err
    assert re.search(says, err)
    assert err.count("\n") == 1
    assert [path.name for path in tmp_path.iterdir()] == ["map.txt"]


def test_an_old_version_of_an_environment_is_refused_without_warnings():
    command = [sys.executable, "-m", "habilis", "empowerment", "gym:Taxi-v3", "--horizon", "1"]
    done = subprocess.run(command, capture_output=True, text=True)
    assert done.returncode == 2
    assert "Taxi-v4" in done.stderr
    assert done.stderr.count("\n") == 1


def test_compare_of_a_map_without_a_tool_compares_what_there_is(capsys, tmp_path):
    (tmp_path / "bare.txt").write_text("A.C.\n....\n...G\n")
    asked = ("compare", str(tmp_path / "bare.txt"), "--horizon", "2")
    status, found = run_json(capsys, *asked)
    assert (status, list(found["averages"])) == (0, ["none"])
    assert run_json(capsys, *asked, "--tools", "none")[1] == found
    assert main([*asked, "--tools", "picker"]) == 2
    assert "no tool whose place a picker could take" in capsys.readouterr().err


def test_json_distinguishes_an_equal_tool_from_one_that_sampled_bounds_leave_open(capsys, tmp_path):
    (tmp_path / "tie.txt").write_text("A.P\n...\n#.#\n.C.\n..G\n")
    asked = ("compare", str(tmp_path / "tie.txt"), "--tools", "none,broom", "--horizon")
    reported = run_json(capsys, *asked, "3")[1]["tools"]["broom"]
    decided = reported["better_than_none"] or reported["encumbers"]
    assert (reported["gap"], reported["equal"]) == (0, not decided)
    sampled = ("--method", "sampled", "--samples", "1")
    reported = run_json(capsys, *asked, "3", *sampled)[1]["tools"]["broom"]
    assert [reported[name] for name in ("better_than_none", "encumbers", "equal")] == [False] * 3
    assert reported["gap"] > 0


def test_a_full_disk_is_one_line():
    with open("/dev/full", "w") as full:
        code = "import sys; from habilis.cli import main; sys.exit(main(['worlds']))"
        done = subprocess.run(
            [sys.executable, "-c", code], stdout=full, stderr=subprocess.PIPE, text=True
        )
    assert done.returncode == 2
    assert "No space left" in done.stderr.splitlines()[0]
    assert "Traceback" not in done.stderr


def test_a_reader_that_goes_away_is_no_error():
    command = f"{sys.executable} -m habilis empowerment yard --horizon 1 | true"
    done = subprocess.run(command, shell=True, stderr=subprocess.PIPE, text=True)
    assert done.stderr == ""


def test_a_file_that_cannot_be_written_is_one_line(capsys, tmp_path):
    out = tmp_path / "no" / "such" / "bits.csv"
    assert main(["empowerment", "yard", "--horizon", "1", "--out", str(out)]) == 2
    assert "cannot be written" in capsys.readouterr().err


@pytest.mark.parametrize("verb", VERBS)
def test_help_has_an_example(verb, capsys):
    with pytest.raises(SystemExit, match="0"):
        main([verb, "--help"])
    assert f"example: habilis {verb}" in " ".join(capsys.readouterr().out.split())


def test_a_missing_extra_says_what_to_install(capsys, monkeypatch, tmp_path):
    for module in [name for name in sys.modules if name.startswith("habilis.learning")]:
        monkeypatch.delitem(sys.modules, module)
    monkeypatch.setitem(sys.modules, "jax", None)
    assert main(["train", "yard", "--out", str(tmp_path / "run")]) == 2
    assert capsys.readouterr().err == (
        "habilis: jax is not installed; run: pip install 'habilis[learn]'\n"
    )
