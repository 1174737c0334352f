"""The benchmark of kinds has a time and a certificate for each."""

import pytest

from habilis import benchmarks
from habilis.benchmarks import kinds, run_benchmarks
from habilis.worlds.world import World


def test_large_sizes_are_of_some_benchmarks_alone():
    with pytest.raises(ValueError, match="--large is of kinds, noise, and not of worlds"):
        run_benchmarks(["worlds"], large=True)


def test_every_kind_has_a_time_and_a_small_gap(monkeypatch: pytest.MonkeyPatch):
    small = World.parse("AP..\n.C..\n...G\n....", "small")
    asked: list[int] = []
    of_lake = kinds._of_lake

    def of_ice(horizon: int) -> list[benchmarks.Result]:
        asked.append(horizon)
        return of_lake(1)

    monkeypatch.setattr(kinds, "load_world", lambda name: small)
    monkeypatch.setattr(kinds, "_of_lake", of_ice)
    monkeypatch.setattr(kinds, "_PRICED", 3)
    monkeypatch.setattr(kinds, "_LARGE", 300)
    monkeypatch.setattr(kinds, "_WHOLE", 50)
    found = run_benchmarks(["kinds"], large=True)
    assert asked == [2, 3]
    times, gaps = found[::2], found[1::2]
    named = " ".join(line.name for line in times)
    for kind in ("effective", "closed loop", "goal-directed", "budget", "each step"):
        assert kind in named
    assert all(line.unit == "s" and line.value > 0 for line in times)
    assert all(line.unit == "bits" and line.value <= 1e-6 for line in gaps)
