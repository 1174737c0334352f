"""An error names what is wrong, where, and how to fix it, in the terms of what was called."""

import re
from pathlib import Path
from typing import Any

import gymnasium
import pytest

import habilis as hb
from habilis.cli import in_flags, main
from habilis.learning.config import Config
from habilis.learning.folder import load_latest, load_run
from habilis.worlds.placements import start_of
from habilis.worlds.reach import reachable

MAP = "A.P.\n..C.\n...G\n"

ABOVE = [
    ("P =", "line 1: 'P =' binds nothing; write one character, '=' and its meaning"),
    ("P =    ", "line 1: 'P =' binds nothing"),
    ("= picker", "line 1: '= picker' binds nothing"),
    ("PP = picker", "line 1: 'PP' is not one character"),
    ("; a comment\nPick = picker", "line 2: 'Pick' is not one character"),
    ("P = PICKER", "line 1: 'P' is bound to 'PICKER', which is unknown; bind it to a tool"),
    ("P == picker", "line 1: 'P' is bound to '= picker', which is unknown"),
    ("drop:", "line 1: 'drop:' is not a setting; the only one is 'drop: true'"),
    ("drop = true", "line 1: 'drop = true' is not a setting; the only one is 'drop: true'"),
    ("Drop: true", "line 1: 'Drop: true' is not a setting"),
    ("drop: true false", "line 1: 'drop: true false' is not a setting"),
    ("slip: 0.1", "line 1: setting 'slip' is unknown"),
    ("p = picker", "line 1: 'p' is bound to 'picker' but is not on the map .the map has 'P'"),
    ("R = rake", "line 1: 'R' is bound to 'rake' but is not on the map; put it on a floor cell"),
    ("P = picker\nD = ball", "line 2: 'D' is bound to 'ball' but is not on the map"),
    ("H = goal of C", "line 1: 'H' is bound to 'goal of C' but is not on the map"),
]


@pytest.mark.parametrize(("above", "says"), ABOVE)
def test_a_line_above_a_map_that_says_nothing_is_refused(above: str, says: str):
    with pytest.raises(ValueError, match=f"map, {says}") as caught:
        hb.World.parse(f"{above}\n{MAP}")
    assert "\n" not in str(caught.value)


def test_a_line_that_binds_below_the_map_is_refused():
    with pytest.raises(ValueError, match="line 4: 'R = rake' binds a character below the"):
        hb.World.parse(MAP + "R = rake\n")


@pytest.mark.parametrize("text", [None, 3, MAP.encode(), MAP.split(), Path("map.txt"), ["A"] * 999])
@pytest.mark.ill_typed
def test_a_map_that_is_no_text_is_refused(text: Any):
    with pytest.raises(ValueError, match=r"the text of a map is .*; give a str") as caught:
        hb.World.parse(text)
    assert len(str(caught.value)) < 300


@pytest.mark.parametrize(
    ("name", "says"),
    [
        (MAP, r"no such world \(this is the text of a map\).*World.parse reads map text"),
        (MAP * 200, r"^'A.P.{1,300}\.\.\.: no such world \(this is the text of a map\)"),
        ("x" * 300, r"^x{200}\.\.\.: no such world \(File name too long\); name one of corridor"),
        ("x/" * 5000, r"\.\.\.: no such world \(File name too long\)"),
        ("a\0b", r"no such world \(embedded null"),
        (
            "gym:FrozenLake-v1",
            r"a Gymnasium environment.*habilis empowerment and train take.*from_gym",
        ),
        (None, "world is None; give a built-in world's name or the path of a map file"),
        (b"yard", "world is b'yard'; give a built-in world's name"),
        (hb.load_world("yard"), "world is <World yard: .*>; give a built-in world's name"),
    ],
)
@pytest.mark.ill_typed
def test_a_name_that_is_no_worlds_is_refused_in_one_short_line(name: Any, says: str):
    with pytest.raises(ValueError, match=says) as caught:
        hb.load_world(name)
    assert "\n" not in str(caught.value)
    assert len(str(caught.value)) < 500


@pytest.mark.parametrize("verb", ["solve", "landscape", "futures", "compare", "worlds", "train"])
def test_verbs_that_take_worlds_say_so_of_environments_and_of_maps_text(verb, capsys, tmp_path):
    more = {"solve": [], "worlds": [], "train": ["--out", str(tmp_path / "run")]}
    names = {"gym:FrozenLake-v1": "habilis empowerment and train take", MAP * 99: "the text"}
    if verb == "train":  # which takes environments
        del names["gym:FrozenLake-v1"]
    for name, says in names.items():
        assert main([verb, name, *more.get(verb, ["--horizon", "1"])]) == 2
        out, err = capsys.readouterr()
        assert out == ""
        assert re.fullmatch(
            rf"habilis: .*{says}.*name one of corridor, corridor-b, yard, yard-b.*\n", err
        )
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("read", [load_run, load_latest])
@pytest.mark.parametrize("name", ["x" * 300, "a\0b"])
def test_a_folder_that_no_system_has_is_refused(read: Any, name: str):
    with pytest.raises(ValueError, match="is not a valid path"):
        read(name)


def test_a_setting_of_another_algorithm_says_whose_it_is(capsys, tmp_path):
    with pytest.raises(ValueError, match="epochs is a setting of ppo, not of a2c; leave it out"):
        Config.from_dict({"epochs": 3})
    with pytest.raises(ValueError, match="clip is a setting of a2c and ppo, not of q-learning"):
        Config().changed(algorithm="q-learning", clip=1.0)
    assert main(["train", "yard", "--epochs", "3", "--out", str(tmp_path / "run")]) == 2
    assert capsys.readouterr().err == (
        "habilis: --epochs is a setting of ppo, not of a2c; leave it out, or choose "
        "--algorithm ppo\n"
    )
    assert list(tmp_path.iterdir()) == []


@pytest.mark.ill_typed
@pytest.mark.parametrize(
    ("measure", "says"),
    [
        ({"hor": 1}, ": argument 'hor' is unknown; use some of horizon, sensor, actions, unit"),
        ({"horizon": 1, "sensors": "object"}, ": argument 'sensors' is unknown"),
        ({"horizon": 1, "mdp": 3}, ": argument 'mdp' is unknown"),
        ({"horizon": 1, "folder": "x"}, ": argument 'folder' is unknown"),
        ({"horizon": 1, 2: 3}, ": argument 2 is unknown"),
        ({"horizon": 1, "states": [0]}, " needs one value for every state; leave out states$"),
        ({}, ' has no horizon; give one, as {"horizon": 6, "sensor": "object"}'),
        (3, " is 3; give arguments of habilis.empowerment"),
        ({"horizon": -1}, ": horizon is -1; give a whole number from 0 up$"),
        ({"horizon": 1, "actions": 3}, ": actions has shape"),
        ({"horizon": 1, "sensor": "smell"}, ": sensor 'smell' is unknown"),
    ],
)
def test_a_measure_that_cannot_be_is_refused_with_what_is_wrong(measure: Any, says: str):
    with pytest.raises(ValueError, match=f"^measure 'x'{says}") as caught:
        gymnasium.make("habilis/Yard-v0", measures={"x": measure})
    assert "kept_empowerment" not in str(caught.value)


@pytest.mark.ill_typed
@pytest.mark.parametrize("name", [1, None, ("x", "y")])
def test_a_measure_is_named_by_a_string(name: Any):
    with pytest.raises(ValueError, match=r"measures has the name .*; give a string$"):
        gymnasium.make("habilis/Yard-v0", measures={name: {"horizon": 1}})


FLAGS = {"max_gib": "--max-gib", "method": "--method", "slip": "--slip", "runs": "--runs"}


@pytest.mark.parametrize(
    ("message", "said"),
    [
        ("raise max_gib or max_seconds", "raise --max-gib or max_seconds (in Python)"),
        ("use method='sampled'", "use --method sampled"),
        ("use method=hb.Sampled()", "use --method sampled"),
        ("use method=hb.Sampled(), or less", "use --method sampled, or less"),
        ("use method='sampled', or less", "use --method sampled, or less"),
        ("give unit='nats'", "give unit='nats' (in Python)"),
        ("give a key= that", "give a key= (in Python) that"),
        ("slip is 2; give less", "--slip is 2; give less"),
        ("point 1: runs is 0", "point 1: --runs is 0"),
        ("a slip is a fall, and runs is 0", "a slip is a fall, and --runs is 0"),
        ("/tmp/max_gib/slip: is not a folder", "/tmp/max_gib/slip: is not a folder"),
        ("'max_gib' is a file", "'max_gib' is a file"),
        ("max_gib.txt is a file", "max_gib.txt is a file"),
        ("go on with --max_gib", "go on with --max_gib"),
        ("the method is new", "the method is new"),
    ],
)
def test_arguments_are_named_by_their_options_on_the_command_line(message: str, said: str):
    assert in_flags(message, FLAGS) == said


def test_an_argument_that_python_lacks_too_is_not_suggested():
    assert in_flags("draw with seed=3 or key=4", FLAGS, ("seed",)) == (
        "draw with seed=3 or key=4 (in Python)"
    )


def test_futures_is_refused_with_advice_that_it_can_follow(capsys: pytest.CaptureFixture):
    for limit in (["1000000000"], ["40", "--max-seconds", "1e-4"], ["40", "--max-gib", "1e-9"]):
        assert main(["futures", "corridor", "--sensor", "object", "--horizon", *limit]) == 2
        out, err = capsys.readouterr()
        assert (out, err.count("\n")) == ("", 1)
        assert err.startswith(f"habilis: horizon {limit[0]} takes about ")
        assert err.endswith("raise --max-gib or --max-seconds\n")
        assert "method" not in err
        assert "(in Python)" not in err
    assert main(["futures", "corridor", "--horizon", "1", "--max-states", "9"]) == 2
    assert "or raise --max-states if" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (["landscape", "yard", "--slip", "0.1", "--horizon", "12"], "raise --max-gib or --max-sec"),
        (["compare", "yard", "--slip", "0.1", "--horizon", "12"], "with --method sampled"),
        (["compare", "yard", "--pairs", "--slip", "0.1", "--horizon", "12"], "raise --max-gib"),
        (["empowerment", "yard", "--horizon", "1", "--max-states", "9"], "raise --max-states"),
        (["solve", "yard", "--max-states", "9"], "raise --max-states"),
        (["landscape", "yard", "--horizon", "-1"], "habilis: --horizon is -1; give a whole"),
        (["empowerment", "yard", "--horizon", "1", "--max-gib", "-1"], "--max-gib is -1.0; give"),
        (["train", "yard", "--learning-rate", "0", "--out", "run"], "--learning-rate is 0.0; give"),
        (
            ["train", "yard", "--intrinsic", "object", "--beta", "1e308", "--out", "run"],
            "--beta is 1e+308; give one from -1e+30 to 1e+30",
        ),
    ],
)
def test_errors_on_the_command_line_name_its_options(
    arguments, says, capsys, monkeypatch, tmp_path
):
    monkeypatch.chdir(tmp_path)
    assert main(arguments) == 2
    err = capsys.readouterr().err
    assert says in err
    names = ("max_gib", "max_seconds", "max_states", "learning_rate")
    assert not re.search(rf"\b({'|'.join(names)})\b", err)
    assert list(tmp_path.iterdir()) == []


def test_every_verb_that_computes_empowerment_takes_its_options(capsys, tmp_path):
    (tmp_path / "map.txt").write_text(MAP)
    small = str(tmp_path / "map.txt")
    command = [small, "--horizon", "1", "--unit", "nats", "--tolerance", "1e-3", "--json"]
    for verb in ("empowerment", "landscape", "compare"):
        assert main([verb, *command, "--method", "sampled", "--samples", "2", "--seed", "1"]) == 0
        capsys.readouterr()
    assert main(["futures", *command, "--max-gib", "1"]) == 0
    capsys.readouterr()
    sampled = ["compare", small, "--horizon", "3", "--method", "sampled", "--samples", "1"]
    assert main(sampled) == 0
    out = capsys.readouterr().out
    assert out.startswith("lower bounds on average 3-step object empowerment")
    assert "perhaps better or worse than none" in out
    assert "equal" not in out


def test_only_who_has_max_states_is_advised_to_raise_it():
    several = hb.World.parse("D = ball\nG = goal of C\nA.PC\n.D.G\n....")
    with pytest.raises(ValueError, match=r"more than 9 placements; ask for a lower horizon$"):
        reachable(several, start_of(several), 8, max_states=9)
    with pytest.raises(ValueError, match="make the map smaller, or raise max_states if there"):
        hb.tabulate(several, max_states=9)
