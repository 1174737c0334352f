"""Landscapes of every kind of empowerment, in Python and on the command line."""

import json

import numpy as np
import polars as pl
import pytest

import habilis as hb
from habilis.cli import main
from habilis.empowerment.kinds import KINDS

SETTINGS = {"effective": {"discount": 0.9}, "goal-directed": {"slack": 2}}
MAP = "#####\n#APC#\n#..G#\n#####"


@pytest.mark.parametrize("kind", KINDS)
def test_a_landscape_has_the_values_of_its_kind(kind):
    world = hb.World.parse(MAP)
    found = hb.landscape(world, 2, "object", kind=kind, **SETTINGS.get(kind, {}))
    mdp = hb.tabulate(world)
    state = mdp.find(agent=(1, 1), tool=(1, 2), object=(1, 3))
    expected = {
        "open-loop": lambda: hb.empowerment(mdp, 2, "object", states=[state]),
        "closed-loop": lambda: hb.closed_loop_empowerment(mdp, 2, "object", [state]),
        "effective": lambda: hb.effective_empowerment(mdp, "uniform", 0.9, "object", [state]),
        "goal-directed": lambda: hb.goal_directed_empowerment(
            mdp, 2, slack=2, sensor="object", states=[state]
        ),
    }[kind]()
    assert found.values[1, 1] == pytest.approx(expected[0])
    assert np.isnan(found.values[0]).all()
    assert kind.split("-")[0] in found.title or kind == "open-loop"


def test_the_command_line_has_every_kind(tmp_path, capsys):
    path = tmp_path / "map.txt"
    path.write_text(MAP)
    options = {"effective": ["--discount", "0.9"], "goal-directed": ["--slack", "2"]}
    for kind in KINDS:
        command = ["landscape", str(path), "--horizon", "2", "--sensor", "object", "--json"]
        assert main([*command, "--kind", kind, *options.get(kind, [])]) == 0
        shown = json.loads(capsys.readouterr().out)
        settings = SETTINGS.get(kind, {})
        found = hb.landscape(hb.World.parse(MAP), 2, "object", kind=kind, **settings)
        np.testing.assert_allclose(np.array(shown.pop("values"), float), found.values)
        if found.gap is not None:
            np.testing.assert_allclose(np.array(shown.pop("gap"), float), found.gap)
        assert shown == ({} if kind == "open-loop" else {"kind": kind, **settings})


@pytest.mark.parametrize(("kind", "slip"), [*((kind, 0.0) for kind in KINDS), ("closed-loop", 0.1)])
def test_tables_carry_the_kind_with_its_settings_and_the_gap(kind, slip, tmp_path):
    settings = SETTINGS.get(kind, {})
    found = hb.landscape(hb.World.parse(MAP), 1, "object", kind=kind, slip=slip, **settings)
    noisy = slip > 0 or kind == "effective"
    named = {} if kind == "open-loop" else {"kind": kind, **settings}
    table = found.to_dataframe()
    assert table.columns == ["row", "column", "bits", *(["gap"] if noisy else []), *named]
    assert table.filter(pl.col("bits").is_not_null()).height == np.isfinite(found.values).sum()
    for name, value in named.items():
        assert set(table[name]) == {value}
    if noisy:
        assert (table["gap"].drop_nulls() <= 1e-6).all()
        assert (table["gap"].is_null() == table["bits"].is_null()).all()
    found.save(tmp_path / "found.csv")
    found.save(tmp_path / "found.npz")
    assert pl.read_csv(tmp_path / "found.csv").columns == table.columns
    assert list(np.load(tmp_path / "found.npz")) == table.columns


def test_goal_directed_landscapes_name_their_slack_of_0():
    found = hb.landscape(hb.World.parse(MAP), 1, "object", kind="goal-directed")
    assert found.settings == {"kind": "goal-directed", "slack": 0}


@pytest.mark.parametrize(
    ("settings", "message"),
    [
        ({"kind": "best"}, "kind is 'best'; use one of open-loop, effective"),
        ({"kind": "effective"}, "discount is None and kind 'effective'; give discount="),
        ({"discount": 0.5}, "discount is 0.5 and kind 'open-loop'; leave out discount"),
        ({"slack": 1}, "slack is 1 and kind 'open-loop', which has none; leave it out"),
        ({"kind": "goal-directed", "actions": [0]}, "is over all actions; leave out actions"),
        ({"kind": "closed-loop", "method": hb.Sampled()}, "has no method but Exact"),
    ],
)
def test_settings_of_another_kind_are_refused(settings, message):
    with pytest.raises(ValueError, match=message):
        hb.landscape(hb.World.parse(MAP), 2, "object", **settings)


def test_a_puzzle_has_no_landscape_of_a_kind_that_needs_every_state(tmp_path):
    path = tmp_path / "rod.pwp"
    path.write_text("A  M0 G0 .\n.  .  .  .\n")
    with pytest.raises(ValueError, match="is a puzzle, of which 'effective' would need every"):
        hb.landscape(hb.load_pushworld(path), 2, "object:m0", kind="effective", discount=0.5)


def test_any_measure_has_a_landscape():
    world = hb.World.parse(MAP)
    mdp = hb.tabulate(world)
    cost = np.arange(1.0, mdp.action_count + 1)[None].repeat(mdp.states, axis=0)

    def within(mdp, states):
        return hb.empowerment(mdp, 2, "object", states=states, cost=cost, budget=6)

    found = hb.landscape_of(world, within, title="within 6", mdp=mdp)
    plain = hb.landscape(world, 2, "object")
    np.testing.assert_array_equal(np.isnan(found.values), np.isnan(plain.values))
    start = mdp.factor("agent")[mdp.start]
    assert found.values.flat[start] == within(mdp, [mdp.start])[0]
    assert found.title == "within 6"


def test_a_measure_returns_a_number_for_each_state():
    world = hb.World.parse(MAP)
    with pytest.raises(ValueError, match=r"measure returns shape \(1,\) and type float64; let it"):
        hb.landscape_of(world, lambda mdp, states: np.zeros(1))
