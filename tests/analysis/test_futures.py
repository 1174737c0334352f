"""The futures an agent would choose among attain its empowerment, and their picture shows them."""

import json
import re
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from labels import labels_on
from slow_channels import divergences

import habilis as hb
from habilis.analysis.futures import arrows_legend, futures, futures_figure, sequence_text
from habilis.cli import main
from habilis.empowerment.tabular.open_loop import exact, problem_of
from habilis.mdp import TabularMDP
from habilis.worlds.table import placement

WORLD = hb.World.parse("......\n.APC..\n......\n.....G", name="room")


def followed(mdp: TabularMDP, start: int, sequence: np.ndarray) -> np.ndarray:
    belief = np.eye(mdp.states)[start]
    for action in sequence:
        belief = belief @ mdp.transition(int(action)).toarray()
    return belief


@settings(max_examples=60, deadline=None)
@given(
    st.integers(1, 5),
    st.integers(1, 3),
    st.integers(0, 3),
    st.sampled_from(["state", "labels", "noisy"]),
    st.booleans(),
    st.integers(0, 2**32 - 1),
)
def test_the_choice_attains_the_empowerment(
    states: int, actions: int, horizon: int, kind: str, certain: bool, seed: int
):
    rng = np.random.default_rng(seed)
    if certain:
        mdp = TabularMDP.deterministic(rng.integers(states, size=(states, actions)))
    else:
        mdp = TabularMDP.stochastic(rng.dirichlet(np.ones(states), (states, actions)))
    labels = rng.integers(10, 13, size=states)
    sensor: Any = {
        "state": "state",
        "labels": labels,
        "noisy": rng.dirichlet(np.ones(3), states),
    }[kind]
    start = int(rng.integers(states))
    found = futures(mdp, start, horizon, sensor)
    assert found.empowerment == pytest.approx(
        hb.empowerment(mdp, horizon, sensor, states=[start])[0], abs=2e-6
    )
    # The sequences lead where the channel says, and their information is the empowerment.
    seen = {"state": np.eye(states), "labels": np.eye(13)[labels], "noisy": sensor}[kind]
    rows = np.array([followed(mdp, start, s) @ seen for s in found.sequences])
    assert np.allclose(rows[:, found.observations], found.channel, atol=1e-9)
    assert found.probability.sum() == pytest.approx(1)
    assert (np.diff(found.probability) <= 0).all()
    each = divergences(rows, found.probability @ rows)
    assert found.probability @ each == pytest.approx(found.empowerment, abs=1e-6)
    assert found.seen.sum() == pytest.approx(1)


def test_certain_futures_are_chosen_alike():
    mdp = hb.tabulate(WORLD)
    found = futures(mdp, mdp.start, 2, "object")
    cells = {divmod(int(cell), WORLD.width) for cell in found.observations}
    assert (1, 3) in cells  # the can may stay
    assert np.allclose(found.probability, 1 / len(found.probability))
    assert np.allclose(found.seen, 1 / len(cells))
    assert found.empowerment == np.log2(len(cells))


def test_only_chosen_actions_are_in_the_sequences():
    mdp = hb.tabulate(WORLD, slip=0.1)
    found = futures(mdp, mdp.start, 2, "object", actions=[1, 5])
    assert set(found.sequences.ravel()) <= {1, 5}


def test_nats_are_bits_times_the_logarithm_of_two():
    mdp = hb.tabulate(WORLD, slip=0.2)
    bits, nats = (futures(mdp, mdp.start, 1, "object", unit=unit) for unit in ("bits", "nats"))
    assert nats.empowerment == pytest.approx(bits.empowerment * np.log(2), abs=1e-6)
    assert nats.unit == "nats"


@pytest.mark.parametrize("suffix", [".png", ".svg", ".pdf"])
def test_the_picture_is_written_and_says_what_it_shows(suffix: str, tmp_path):
    from habilis.worlds.pictures.figures import save_figure

    mdp = hb.tabulate(WORLD, slip=0.05)
    found = futures(mdp, mdp.start, 2, "object")
    figure = futures_figure(placement(WORLD, mdp, mdp.start), mdp, found, "object")
    save_figure(figure, tmp_path / f"futures{suffix}")
    assert (tmp_path / f"futures{suffix}").stat().st_size > 1000
    title = figure._suptitle.get_text()  # type: ignore[attr-defined]
    assert f"{found.empowerment:.3f} bits" in title
    shown = {text.get_text() for text in labels_on(figure.axes[0])}
    assert {f"{100 * p:.1f}" for p in found.seen} == shown


def test_sequences_are_arrows_in_a_world_and_names_or_numbers_elsewhere():
    assert sequence_text(hb.tabulate(WORLD), np.array([0, 1, 6, 7])) == "↑→⇓⇐"
    mdp = TabularMDP.deterministic([[0, 0]])
    assert sequence_text(mdp, np.array([0, 1])) == "0 1"
    assert sequence_text(replace(mdp, actions=("stay", "wait")), np.array([0, 1])) == "stay wait"


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"state": 99_999}, "states has 99999"),
        ({"horizon": -1}, "horizon is -1"),
        ({"sensor": "nose"}, "sensor 'nose' is unknown"),
        ({"unit": "bytes"}, "unit is 'bytes'"),
        ({"method": hb.Sampled()}, "method is Sampled("),
        (
            {"sensor": "agent + object"},
            "sensor is 'agent + object', and futures are those of a single",
        ),
    ],
)
@pytest.mark.ill_typed
def test_bad_input_is_refused(arguments: Any, message: str):
    with pytest.raises(ValueError, match=re.escape(message)):
        futures(hb.tabulate(WORLD), **({"state": 0, "horizon": 1} | arguments))


def test_what_does_not_fit_is_refused_with_the_largest_horizon_that_does():
    mdp = hb.tabulate(hb.load_world("yard"), slip=0.1)
    with pytest.raises(ValueError, match=r"horizon 30 takes about .* that fits is about \d+"):
        futures(mdp, mdp.start, 30, method=hb.Exact(max_gib=0.01))


def test_the_command_line_shows_futures(capsys: pytest.CaptureFixture[str], tmp_path):
    map_file = tmp_path / "room.txt"
    map_file.write_text(WORLD.text())
    out = tmp_path / "futures.png"
    arguments = ["futures", str(map_file), "--horizon", "2", "--sensor", "object"]
    assert main([*arguments, "--json", "--slip", "0.1", "--out", str(out)]) == 0
    answer = json.loads(capsys.readouterr().out)
    mdp = hb.tabulate(WORLD, slip=0.1)
    bits = hb.empowerment(mdp, 2, "object", states=[mdp.start])[0]
    assert answer["empowerment"] == pytest.approx(bits, abs=2e-6)
    assert sum(answer["seen"]) == pytest.approx(1)
    assert out.exists()
    assert main([*arguments, "--agent-at", "0,0"]) == 0
    assert capsys.readouterr().out.startswith("0.0000 bits, 1 possible observation\n")


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (["--agent-at", "0,99"], "the agent is at (0, 99)"),
        (["--tool", "none", "--tool-at", "0,0"], "has no tool here"),
        (["--out", "x.png"], "a picture needs cells; use --sensor agent, tool, object"),
    ],
)
def test_bad_questions_on_the_command_line_get_one_line(
    arguments: list[str], message: str, capsys: pytest.CaptureFixture[str]
):
    assert main(["futures", "yard", "--horizon", "1", *arguments]) == 2
    error = capsys.readouterr().err
    assert message in error
    assert error.count("\n") == 1


@pytest.mark.parametrize("limit", [{"max_gib": 1e-9}, {"max_seconds": 1e-9}])
def test_futures_keep_to_both_limits(limit: Any):
    mdp = hb.tabulate(WORLD)
    with pytest.raises(ValueError, match=r"horizon 8 takes about .*: .*raise max_gib or max_sec"):
        futures(mdp, mdp.start, 8, method=hb.Exact(**limit))
    assert futures(mdp, mdp.start, 8).empowerment > 0


def test_the_channel_of_certain_futures_is_foreseen_too():
    """Every state from every state, in a row and a column each: 30,000 x 30,000 numbers."""
    mdp = hb.tabulate(hb.load_world("yard"))
    with pytest.raises(ValueError, match=r"horizon 60 takes about \d+\.?\d* GiB"):
        futures(mdp, mdp.start, 60)


def test_futures_say_how_many_of_their_actions_are_done():
    slippery = hb.tabulate(WORLD, 0.1)
    for mdp in (hb.tabulate(WORLD), slippery):
        reported: list[tuple[int, int]] = []
        problem = problem_of(mdp, 3, "object", np.arange(4), 1e-6)
        exact(
            problem,
            mdp.start,
            lambda done, known, reported=reported: reported.append((done, known)),
        )
        assert reported == [(1, 3), (2, 3), (3, 3)]


@pytest.mark.parametrize(
    ("world", "legend"),
    [
        ("yard", "↑→↓← move the agent, ⇑⇒⇓⇐ put the tool on that side of it"),
        ("drop: true\nT = rake\nA.T\n.C.\n..G\n", "↧ puts it down"),
    ],
)
def test_arrows_have_a_legend(world: str, legend: str):
    found = hb.load_world(world) if world == "yard" else hb.World.parse(world)
    assert arrows_legend(hb.tabulate(found)).endswith(legend)


def test_actions_with_names_need_no_legend():
    assert arrows_legend(hb.TabularMDP.deterministic([[0, 1], [1, 0]])) == ""
