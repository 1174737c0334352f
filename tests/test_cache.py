"""Cached results are kept whole or not at all."""

import threading

import numpy as np
import pytest

import habilis as hb
from habilis.cache import cache_folder, fingerprint, kept
from habilis.rewards.cached_tables import kept_empowerment

VALUES = np.linspace(0, 1, 7)


def forbidden():
    raise AssertionError("computed again")


def test_the_second_time_it_is_read(tmp_path):
    assert np.array_equal(kept("name", lambda: {"x": VALUES}, tmp_path)["x"], VALUES)
    assert np.array_equal(kept("name", forbidden, tmp_path)["x"], VALUES)


def test_another_name_is_another_array(tmp_path):
    kept("name", lambda: {"x": VALUES}, tmp_path)
    assert np.array_equal(kept("other", lambda: {"x": 2 * VALUES}, tmp_path)["x"], 2 * VALUES)


@pytest.mark.parametrize("damage", ["cut", "changed", "emptied"])
def test_a_damaged_file_is_made_again(tmp_path, damage):
    kept("name", lambda: {"x": VALUES}, tmp_path)
    path = tmp_path / "name.npz"
    content = path.read_bytes()
    changed = content[:200] + bytes([content[200] ^ 1]) + content[201:]
    path.write_bytes({"cut": content[:-9], "changed": changed, "emptied": b""}[damage])
    assert np.array_equal(kept("name", lambda: {"x": VALUES + 1}, tmp_path)["x"], VALUES + 1)
    assert np.array_equal(kept("name", forbidden, tmp_path)["x"], VALUES + 1)


def test_what_is_not_accepted_is_made_again(tmp_path):
    kept("name", lambda: {"x": VALUES}, tmp_path)
    again = kept("name", lambda: {"x": 2 * VALUES}, tmp_path, accept=lambda arrays: False)
    assert np.array_equal(again["x"], 2 * VALUES)
    assert np.array_equal(kept("name", forbidden, tmp_path)["x"], 2 * VALUES)


def test_a_place_that_cannot_be_written_only_keeps_nothing(tmp_path):
    (tmp_path / "file").write_text("no folder")
    for _ in range(2):
        assert np.array_equal(kept("name", lambda: {"x": VALUES}, tmp_path / "file")["x"], VALUES)


def test_nothing_half_written_is_left_and_many_may_write_at_once(tmp_path):
    threads = [
        threading.Thread(target=kept, args=("name", lambda: {"x": VALUES}, tmp_path))
        for _ in range(8)
    ]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert [path.name for path in tmp_path.iterdir()] == ["name.npz"]
    assert np.array_equal(kept("name", forbidden, tmp_path)["x"], VALUES)


def test_fingerprints_distinguish_contents():
    contents = [
        np.arange(4),
        np.arange(4.0),
        np.arange(4).reshape(2, 2),
        np.arange(5),
        3,
        3.0,
        "3",
        True,
        None,
        [1, 2],
    ]
    assert len({fingerprint(content) for content in contents}) == len(contents)
    assert fingerprint(1, 23) != fingerprint(12, 3)
    assert fingerprint(np.arange(4)[::2]) == fingerprint(np.array([0, 2]))


def test_the_folder_is_where_caches_go(monkeypatch, tmp_path):
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    assert cache_folder() == tmp_path / "habilis"
    monkeypatch.delenv("XDG_CACHE_HOME")
    monkeypatch.setenv("HOME", str(tmp_path))
    assert cache_folder() == tmp_path / ".cache" / "habilis"


@pytest.mark.parametrize("slip", [0.0, 0.1])
def test_kept_empowerment_goes_by_all_that_it_depends_on(tmp_path, slip):
    world = hb.World.parse("AP.CG\n.....\n")
    mdp = hb.tabulate(world, slip)
    noisy = np.full((mdp.states, 2), 0.5)
    asked = [
        (mdp, (1, "state")),
        (mdp, (2, "state")),
        (mdp, (1, "object")),
        (mdp, (1, "object", [0, 1])),
        (hb.tabulate(world.with_tool("broom"), slip), (1, "object")),
        (mdp, (1, np.arange(mdp.states) % 3)),
        (mdp, (1, noisy)),
    ]
    for table, arguments in asked:
        kept_values = kept_empowerment(table, *arguments, folder=tmp_path)
        assert np.allclose(kept_values, hb.empowerment(table, *arguments))
    nats = kept_empowerment(mdp, 1, "state", folder=tmp_path, unit="nats")
    assert np.allclose(nats, hb.empowerment(mdp, 1, "state", unit="nats"))
    assert len(list(tmp_path.iterdir())) == len(asked) + 1


def test_what_a_computation_may_cost_makes_no_other_values(tmp_path):
    mdp = hb.tabulate(hb.World.parse("AP.CG"), slip=0.1)
    for method in (hb.Exact(), hb.Exact(threads=2, max_gib=1.0), hb.Exact(max_seconds=60.0)):
        kept_empowerment(mdp, 2, "object", folder=tmp_path, method=method)
    assert len(list(tmp_path.iterdir())) == 1
    others = [hb.Exact(1e-3), hb.Sampled(3), hb.Sampled(4), hb.Sampled(4, 1)]
    for method in [*others, hb.Sampled(4, 1, threads=2)]:
        found = kept_empowerment(mdp, 2, "object", folder=tmp_path, method=method)
        np.testing.assert_array_equal(found, hb.empowerment(mdp, 2, "object", method=method))
    assert len(list(tmp_path.iterdir())) == 1 + len(others)


def test_equal_tables_share_what_is_kept(tmp_path):
    for name in ("one", "other"):
        mdp = hb.tabulate(hb.World.parse("AP.CG\n.....\n", name))
        kept_empowerment(mdp, 2, "object", folder=tmp_path)
        kept_empowerment(mdp, 2, mdp.factor("object"), folder=tmp_path)
    assert len(list(tmp_path.iterdir())) == 1
