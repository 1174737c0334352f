"""A saved table is read back as it was, or the file is refused and nothing is lost."""

import hashlib
import json
from collections.abc import Callable
from dataclasses import replace
from io import BytesIO
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from available import as_probabilities, random_probabilities, random_table
from hypothesis import given, settings
from hypothesis import strategies as st

import habilis as hb
from habilis import checksums
from habilis.checksums import read_arrays, write_arrays
from habilis.files import write_whole
from habilis.mdp import TabularMDP

SEEDS = st.integers(0, 2**32 - 1)
RING = TabularMDP.deterministic([[1, 2], [2, 0], [0, -1]], reward=[[0, 1], [2, 3], [4, 0]])


def assert_same(one: TabularMDP, other: TabularMDP):
    assert one.is_stochastic == other.is_stochastic
    for action in range(one.action_count):
        assert abs(one.transition(action) - other.transition(action)).nnz == 0
    for name in ("available", "reward", "terminal"):
        ours, theirs = getattr(one, name), getattr(other, name)
        assert ours.dtype == theirs.dtype
        assert np.array_equal(ours, theirs)
    for kind in ("factors", "flags"):
        ours, theirs = getattr(one, kind), getattr(other, kind)
        assert list(ours) == list(theirs)
        for name, labels in ours.items():
            assert labels.dtype == theirs[name].dtype
            assert np.array_equal(labels, theirs[name])
    for name in ("start", "shape", "actions", "cells"):
        assert getattr(one, name) == getattr(other, name)
    if one.entry_reward is None or other.entry_reward is None:
        assert one.entry_reward is other.entry_reward
    else:
        assert np.array_equal(one.entry_reward, other.entry_reward)


@st.composite
def tables(draw) -> TabularMDP:
    """Deterministic and stochastic, with actions that are not available, and all else there is."""
    rng = np.random.default_rng(draw(SEEDS))
    P = as_probabilities(random_table(rng)) if draw(st.booleans()) else random_probabilities(rng)
    states, actions, _ = P.shape
    mdp = TabularMDP.stochastic(
        P, rng.normal(size=(states, actions)), rng.random(states) < 0.3, int(rng.integers(states))
    )
    names = st.lists(st.text(max_size=5), unique=True, max_size=3)
    wide = rng.integers(-(2**31), 2**31, size=states).astype(np.int32)
    factors = {name: np.roll(wide, i) for i, name in enumerate(draw(names))}
    letters = st.lists(st.text(min_size=1), min_size=actions, max_size=actions, unique=True).map(
        tuple
    )
    return replace(
        mdp,
        factors=factors,
        flags={name: rng.random(states) < 0.5 for name in draw(names)},
        shape=draw(st.none() | st.tuples(st.integers(1, 9), st.integers(1, 9))),
        actions=draw(st.just(()) | letters),
        entry_reward=draw(st.sampled_from([None, rng.normal(size=states).astype(np.float32)])),
        cells=draw(st.none() | st.just(frozenset(list(factors)[:1]))),
    )


@settings(max_examples=60, deadline=None)
@given(tables())
def test_a_table_is_read_back_as_it_was(tmp_path_factory, mdp: TabularMDP):
    path = tmp_path_factory.mktemp("tables") / "m.npz"
    mdp.save(path)
    assert_same(mdp, TabularMDP.load(path))
    assert [file.name for file in path.parent.iterdir()] == ["m.npz"]


def test_the_table_of_a_world_has_its_factors_flags_and_cells(tmp_path: Path):
    mdp = hb.tabulate(hb.World.parse("AP.\n.C.\n..G"), slip=0.1)
    mdp.save(tmp_path / "corridor.npz")
    found = hb.TabularMDP.load(str(tmp_path / "corridor.npz"))
    assert_same(mdp, found)
    assert list(found.factors) == ["agent", "tool", "object"]
    where = {"agent": (0, 0), "tool": (0, 1), "object": (2, 1)}
    assert found.find(**where) == mdp.find(**where)


def test_states_of_a_model_and_an_environment_stay_behind(tmp_path: Path):
    class Coin:
        actions, initial = ("turn",), "heads"

        def step(self, state: str, action: int) -> str:
            return "tails" if state == "heads" else "heads"

    mdp = hb.explore(Coin())
    mdp.save(tmp_path / "coin.npz")
    found = TabularMDP.load(tmp_path / "coin.npz")
    assert found.next_state.tolist() == [[1], [0]]
    assert found.actions == ("turn",)
    with pytest.raises(ValueError, match="not made of a model"):
        found.state(0)


def content_of(mdp: TabularMDP, folder: Path) -> bytes:
    mdp.save(folder / "whole.npz")
    return (folder / "whole.npz").read_bytes()


@settings(max_examples=60, deadline=None)
@given(st.data())
def test_no_damaged_file_is_read(tmp_path_factory, data: st.DataObject):
    folder = tmp_path_factory.mktemp("damaged")
    content = content_of(RING.slippery(0.1) if data.draw(st.booleans()) else RING, folder)
    at = data.draw(st.integers(0, len(content) - 1))
    flipped = content[:at] + bytes([content[at] ^ data.draw(st.integers(1, 255))])
    damaged = data.draw(st.sampled_from([content[:at], flipped + content[at + 1 :], content * 2]))
    path = folder / "m.npz"
    path.write_bytes(damaged)
    least = data.draw(st.sampled_from([0, checksums.MAPPED]))
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(checksums, "MAPPED", least)
        with pytest.raises(ValueError, match=r"m\.npz: .*; (save the table again|pass its arrays)"):
            TabularMDP.load(path)
    assert path.read_bytes() == damaged


def is_mapped(array: np.ndarray) -> bool:
    base = array
    while isinstance(base.base, np.ndarray):
        base = base.base
    return isinstance(base, np.memmap)


def large_ring() -> TabularMDP:
    states = np.arange(200_000)
    ring = TabularMDP.deterministic(np.stack([states - 1, states + 1], axis=1) % len(states))
    return replace(
        ring, factors={"half": (states % 2).astype(np.int32), "place": states.astype(np.int32)}
    )


def test_large_arrays_stay_in_the_file_and_changes_do_not_reach_it(tmp_path: Path):
    mdp, path = large_ring(), tmp_path / "m.npz"
    mdp.save(path)
    content = path.read_bytes()
    found = TabularMDP.load(path)
    for array in (found.next_state, found.reward, found.factors["place"]):
        assert is_mapped(array)
        assert array.flags.aligned
        assert array.flags.c_contiguous
    assert not is_mapped(found.terminal), "a small one is read"
    assert_same(mdp, found)
    found.next_state[0, 0] = 7
    assert found.next_state[0, 0] == 7
    assert path.read_bytes() == content
    mdp.save(path)  # which leaves the file that is mapped where it is
    assert found.next_state[0].tolist() == [7, 1]
    assert hb.empowerment(TabularMDP.load(path), 1, states=[5]).tolist() == [1.0]


def test_the_arrays_of_a_stochastic_table_stay_in_the_file_too(tmp_path: Path):
    mdp = large_ring().slippery(0.2)
    mdp.save(tmp_path / "m.npz")
    found = TabularMDP.load(tmp_path / "m.npz")
    assert_same(mdp, found)
    transitions: Any = found.transitions
    assert is_mapped(transitions.data)
    assert is_mapped(transitions.indices)


def test_files_of_earlier_versions_are_read(tmp_path: Path):
    """Which have their arrays anywhere, so that they cannot be mapped."""
    mdp, path = large_ring(), tmp_path / "m.npz"
    mdp.save(path)
    content = BytesIO()
    np.savez(content, allow_pickle=False, **read_arrays(path))
    path.write_bytes(content.getvalue() + hashlib.sha256(content.getvalue()).digest())
    found = TabularMDP.load(path)
    assert_same(mdp, found)
    for array in (found.next_state, found.reward, found.factors["place"]):
        assert array.flags.aligned


def test_every_size_of_array_is_mapped_or_read(tmp_path: Path, monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setattr("habilis.checksums.MAPPED", 0)
    for size in (0, 1, 63, 64, 65):
        path = tmp_path / f"{size}.npz"
        arrays = {f"name{'s' * size}": np.arange(size), "words": np.array("ab" * size)}
        write_whole(path, lambda file, arrays=arrays: write_arrays(file, arrays))
        found = read_arrays(path, mapped=True)
        assert list(found) == list(arrays)
        for name, array in arrays.items():
            assert found[name].dtype == array.dtype
            assert np.array_equal(found[name], array)
            assert is_mapped(found[name]) == (array.size > 0)
            assert found[name].flags.aligned


def header(**changes: object) -> Callable[[dict], None]:
    def change(arrays: dict) -> None:
        arrays["header"] = np.array(json.dumps(json.loads(str(arrays["header"])) | changes))

    return change


def array(name: str, value: object, dtype: type | None = None) -> Callable[[dict], None]:
    def change(arrays: dict) -> None:
        arrays[name] = np.asarray(value, dtype or arrays[name].dtype)

    return change


def without(name: str) -> Callable[[dict], None]:
    return lambda arrays: arrays.pop(name)


@pytest.mark.parametrize(
    ("change", "reason"),
    [
        (header(format="another"), "its header is not that of a table"),
        (array("header", "{"), "Expecting property name"),
        (header(edition=2), "it has edition 2, and this version reads 1"),
        (header(start=3), "start is 3, of 3 states"),
        (header(start=True), "start is True, of 3 states"),
        (header(shape=[3]), r"shape is \[3\], not rows and columns"),
        (header(shape=5), "has no len"),
        (header(actions=["a"]), "actions has 1 names for 2 actions"),
        (header(actions=["a", "a"]), "not a list of different names"),
        (header(factors=["f"]), r"factors is int32\[0, 3\], not int32\[1, 3\]"),
        (header(flags="g"), "flags is 'g', not a list of different names"),
        (header(cells=[1]), r"cells is \[1\], not a list of different names"),
        (array("reward", [1.0, 2.0]), r"reward has shape \(2,\)"),
        (array("reward", np.full((3, 2), np.nan)), "reward has entries that are not finite"),
        (array("reward", np.zeros((3, 2)), np.float64), r"reward is float64\[3, 2\]"),
        (array("terminal", [False, True]), r"terminal is bool\[2\], not bool\[3\]"),
        (without("terminal"), "terminal is missing"),
        (without("reward"), "reward is missing"),
        (without("next_state"), "probability is missing"),
        (array("next_state", [[0, 1], [2, 3], [0, 0]]), "next_state has entries that are none"),
        (array("next_state", [[0, 1], [2, -2], [0, 0]]), "next_state has entries that are none"),
        (array("next_state", [[0, 1], [2, 1]]), r"next_state is int32\[2, 2\]"),
    ],
)
def test_a_file_whose_parts_do_not_fit_is_refused(
    tmp_path: Path, change: Callable[[dict], None], reason: str
):
    check_refused(RING, tmp_path, change, reason)


@pytest.mark.parametrize(
    ("change", "reason"),
    [
        (array("probability", np.full(14, 0.3)), "probability of state 0, action 0 does not sum"),
        (array("probability", [1.5, -0.5] * 7), "probability has zeros, negative or repeated"),
        (array("probability", np.full(14, np.inf)), "probability has entries that are not finite"),
        (array("probability", np.full(3, 0.5)), r"probability is float64\[3\]"),
        (array("column", np.full(14, 1)), "repeated entries"),
        (array("column", np.full(14, 3)), "first or column has entries that are none"),
        (array("column", np.zeros(14), np.float64), "column is float64"),
        (array("first", np.zeros(7)), "first does not divide probability into 6 rows"),
        (array("first", [0, 2, 1, 4, 4, 6, 14]), "first or column has entries that are none"),
        (without("first"), "first is missing"),
    ],
)
def test_a_stochastic_table_whose_parts_do_not_fit_is_refused(
    tmp_path: Path, change: Callable[[dict], None], reason: str
):
    mdp = TabularMDP.stochastic([[[0.5, 0.5, 0]] * 2, [[0, 0.5, 0.5]] * 2, [[0.2, 0.3, 0.5]] * 2])
    check_refused(mdp, tmp_path, change, reason)


def check_refused(
    mdp: TabularMDP, folder: Path, change: Callable[[dict], None], reason: str
) -> None:
    path = folder / "m.npz"
    mdp.save(path)
    arrays = read_arrays(path)
    change(arrays)
    content = BytesIO()
    write_arrays(content, arrays)
    path.write_bytes(content.getvalue())
    with pytest.raises(
        ValueError, match=rf"m\.npz: is not a usable table.*{reason}.*; save the table"
    ):
        TabularMDP.load(path)


def test_arrays_of_others_are_named(tmp_path: Path):
    np.savez(tmp_path / "bridge.npz", transitions=np.zeros((2, 2), int), rewards=np.zeros((2, 2)))
    with pytest.raises(ValueError, match=r"\(it has transitions, rewards\); pass its arrays to"):
        TabularMDP.load(tmp_path / "bridge.npz")


@pytest.mark.parametrize("content", [b"", b"no zip", b"PK\x03\x04"])
def test_what_is_no_such_file_is_refused(tmp_path: Path, content: bytes):
    (tmp_path / "m.npz").write_bytes(content)
    with pytest.raises(ValueError, match="is damaged, or was not written by"):
        TabularMDP.load(tmp_path / "m.npz")


def test_nothing_of_pickles_is_run(tmp_path: Path):
    class Evil:
        def __reduce__(self):
            return (Path.touch, (tmp_path / "ran",))

    np.savez(tmp_path / "m.npz", header=np.array([Evil()], object))
    with pytest.raises(ValueError, match="is damaged, or was not"):
        TabularMDP.load(tmp_path / "m.npz")
    assert not (tmp_path / "ran").exists()


def test_where_there_is_no_file_says_so(tmp_path: Path):
    with pytest.raises(ValueError, match=r"none\.npz: cannot be read \(No such file"):
        TabularMDP.load(tmp_path / "none.npz")
    with pytest.raises(ValueError, match=r"cannot be read \(Is a directory"):
        TabularMDP.load(tmp_path)
    with pytest.raises(ValueError, match="cannot be read"):
        TabularMDP.load("m\0.npz")


@pytest.mark.ill_typed
def test_a_table_that_could_not_be_read_replaces_none(tmp_path: Path):
    whole = content_of(RING, tmp_path)
    for wrong in (
        replace(RING, factors={"far": np.array([0, 1, 2**40])}),
        replace(RING, factors={"short": np.zeros(2, np.int32)}),
        replace(RING, reward=np.full((3, 2), np.nan, np.float32)),
        replace(RING, start=7),
    ):
        with pytest.raises(ValueError, match=r"whole\.npz: the table cannot be saved: "):
            wrong.save(tmp_path / "whole.npz")
        assert (tmp_path / "whole.npz").read_bytes() == whole


def test_where_a_file_cannot_go_it_is_refused(tmp_path: Path):
    with pytest.raises(ValueError, match=r"unknown suffix '\.csv'"):
        RING.save(tmp_path / "m.csv")
    with pytest.raises(ValueError, match="there is no folder"):
        RING.save(tmp_path / "none" / "m.npz")
    assert not list(tmp_path.iterdir())
