"""Values of states become tables and files that other tools read."""

from pathlib import Path

import numpy as np
import polars as pl
import pytest

import habilis as hb

ROOM = hb.World.parse("A..\nP#.\n.C.\n..G\n", "room")
SUFFIXES = [".csv", ".parquet", ".npz", ".npy"]


def read(path: Path) -> dict[str, np.ndarray]:
    """The columns of a file; that of an .npy is named "bits"."""
    if path.suffix == ".npy":
        return {"bits": np.load(path)}
    if path.suffix == ".npz":
        with np.load(path) as arrays:
            return dict(arrays)
    table = pl.read_csv(path) if path.suffix == ".csv" else pl.read_parquet(path)
    return {column.name: column.to_numpy() for column in table}


def test_a_row_names_cells_by_row_and_column():
    mdp = hb.tabulate(ROOM)
    bits = hb.empowerment(mdp, 1)
    table = hb.to_dataframe(mdp, bits)
    assert table["bits"].to_list() == bits.tolist()
    state = mdp.find(agent=(0, 0), tool=(1, 0), object=(2, 1))
    row = table.row(state, named=True)
    assert (row["agent_row"], row["agent_column"]) == (0, 0)
    assert (row["tool_row"], row["tool_column"]) == (1, 0)
    assert row["equipped"] is True
    assert row["state"] == state


def test_several_measures_stand_side_by_side():
    mdp = hb.tabulate(ROOM)
    foe, toe = hb.empowerment(mdp, 1), hb.empowerment(mdp, 1, "object")
    named = hb.to_dataframe(mdp, foe=foe, toe=toe)
    assert named.columns[-2:] == ["foe", "toe"]
    assert named["toe"].to_list() == toe.tolist()
    assert hb.to_dataframe(mdp, {"foe": foe, "toe": toe}).equals(named)
    assert hb.to_dataframe(mdp, {"foe": foe}, toe=toe).equals(named)
    assert "bits" not in hb.to_dataframe(mdp).columns


def test_any_mdp_has_a_table():
    noisy = hb.TabularMDP.stochastic([[[0.5, 0.5]], [[0.0, 1.0]]])
    table = hb.to_dataframe(noisy, hb.empowerment(noisy, 1))
    assert table.columns == ["state", "bits"]
    assert len(table) == 2


def test_factors_without_a_map_stay_labels():
    gymnasium = pytest.importorskip("gymnasium")
    mdp = hb.TabularMDP.from_gymnasium(gymnasium.make("Taxi-v4"))
    table = hb.to_dataframe(mdp)
    for name in mdp.factors:
        columns = [name] if mdp.shape is None else [f"{name}_row", f"{name}_column"]
        assert set(columns) <= set(table.columns)


def test_rows_can_be_of_some_states():
    mdp = hb.tabulate(ROOM)
    held = mdp.flags["equipped"]
    table = hb.to_dataframe(mdp, hb.empowerment(mdp, 1, states=held), states=held)
    whole = hb.to_dataframe(mdp, hb.empowerment(mdp, 1))
    assert table.equals(whole.filter(pl.col("equipped")))


def test_values_that_do_not_fit_are_refused():
    mdp = hb.TabularMDP.deterministic([[0], [1], [1]])
    with pytest.raises(ValueError, match=r"foe has shape \(2,\); give one value .* 3 states"):
        hb.to_dataframe(mdp, foe=[1.0, 2.0])
    with pytest.raises(ValueError, match="'bits' exists already"):
        hb.to_dataframe(mdp, np.zeros(3), bits=np.zeros(3))
    with pytest.raises(ValueError, match="'state' exists already"):
        hb.to_dataframe(mdp, state=np.zeros(3))
    with pytest.raises(ValueError, match="indices from 0 to 2"):
        hb.to_dataframe(mdp, states=[3])


@pytest.mark.parametrize("suffix", SUFFIXES)
def test_a_file_holds_what_the_table_holds(suffix: str, tmp_path: Path):
    mdp = hb.tabulate(ROOM)
    table = hb.to_dataframe(mdp, hb.empowerment(mdp, 2, "object"))
    hb.save_table(table, tmp_path / f"t{suffix}")
    back = read(tmp_path / f"t{suffix}")
    assert list(back) == (["bits"] if suffix == ".npy" else table.columns)
    for name, column in back.items():
        np.testing.assert_array_equal(column, table[name].to_numpy())


def test_nulls_are_nan_in_arrays(tmp_path: Path):
    table = pl.DataFrame({"bits": [1.0, None]})
    for suffix in (".npy", ".npz"):
        hb.save_table(table, tmp_path / f"t{suffix}")
        np.testing.assert_array_equal(read(tmp_path / f"t{suffix}")["bits"], [1.0, np.nan])


def test_an_array_file_is_for_one_column_of_values(tmp_path: Path):
    mdp = hb.TabularMDP.deterministic([[0], [1]])
    two = hb.to_dataframe(mdp, foe=[1.0, 2.0], toe=[1.0, 2.0])
    with pytest.raises(ValueError, match=r"one column of values, here are foe, toe; use \.npz"):
        hb.save_table(two, tmp_path / "t.npy")
    with pytest.raises(ValueError, match="here are none"):
        hb.save_table(hb.to_dataframe(mdp), tmp_path / "t.npy")
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("name", ["t.txt", "t", "t.csv.gz"])
def test_another_suffix_is_refused_and_all_that_there_are_named(name: str, tmp_path: Path):
    with pytest.raises(ValueError, match=r"\.csv, \.parquet, \.npz, \.npy"):
        hb.save_table(pl.DataFrame({"bits": [1.0]}), tmp_path / name)
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("suffix", SUFFIXES)
def test_a_place_that_cannot_be_written_is_one_line(suffix: str, tmp_path: Path):
    with pytest.raises(ValueError, match="cannot be written") as caught:
        hb.save_table(pl.DataFrame({"bits": [1.0]}), tmp_path / "nowhere" / f"t{suffix}")
    assert "\n" not in str(caught.value)
