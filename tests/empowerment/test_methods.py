"""A method holds the settings by which a capacity is found; measures take nothing else of them."""

import re
import subprocess
import sys
import warnings
from collections.abc import Callable
from pathlib import Path
from typing import Any

import gymnasium
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from tables import labelled_tables

import habilis as hb
from habilis.analysis.averages import average_empowerment, compare
from habilis.analysis.futures import futures
from habilis.analysis.influence import influence_range, latency, reliability
from habilis.analysis.usefulness import usefulness
from habilis.empowerment.horizons import empowerment_by_horizon

WORLD = hb.World.parse("AP.C.G")
TABLE = hb.tabulate(WORLD)
NOISY = TABLE.slippery(0.2)

MEASURES: dict[str, Callable[..., Any]] = {
    "empowerment": lambda **options: hb.empowerment(NOISY, 2, "object", **options),
    "empowerment_by_horizon": lambda **options: empowerment_by_horizon(NOISY, 2, **options),
    "average_empowerment": lambda **options: average_empowerment(NOISY, 2, **options),
    "compare": lambda **options: compare(WORLD, ["broom", "none"], 2, slip=0.2, **options),
    "usefulness": lambda **options: usefulness(WORLD, 2, slip=0.2, **options).with_tool,
    "latency": lambda **options: latency(NOISY, 2, **options),
    "influence_range": lambda **options: influence_range(NOISY, 2, **options),
    "reliability": lambda **options: reliability(WORLD, 2, slip=0.2, **options),
    "landscape": lambda **options: hb.landscape(WORLD, 2, "object", slip=0.2, **options).values,
    "pairs": lambda **options: hb.pairs(WORLD, 2, slip=0.2, **options).averages,
    "futures": lambda **options: futures(NOISY, TABLE.start, 2, "object", **options).empowerment,
}
"""Every public function with a method, by its name."""


# What is refused


@pytest.mark.parametrize(
    ("setting", "message"),
    [
        ({"tolerance": 0}, "tolerance is 0; give a number of bits above 0"),
        ({"tolerance": float("nan")}, "tolerance is nan"),
        ({"threads": 0}, "threads is 0; give a whole number from 1 up"),
        ({"threads": True}, "threads is True"),
        ({"threads": 1.5}, "threads is 1.5"),
        ({"max_gib": 0}, "max_gib is 0; give a number above 0"),
        ({"max_gib": -1}, "max_gib is -1"),
        ({"max_seconds": "1"}, "max_seconds is '1'; give a number above 0"),
    ],
)
@pytest.mark.parametrize("kind", [hb.Exact, hb.Sampled])
@pytest.mark.ill_typed
def test_a_setting_out_of_its_range_is_refused_in_one_line(kind: Any, setting: Any, message: str):
    with pytest.raises(ValueError, match=f"^{re.escape(message)}") as refused:
        kind(**setting)
    assert "\n" not in str(refused.value)


@pytest.mark.parametrize(
    ("setting", "message"),
    [
        ({"samples": 0}, "samples is 0; give a whole number from 1 up"),
        ({"samples": 2.5}, "samples is 2.5"),
        ({"seed": -1}, "seed is -1; give a whole number from 0 up"),
    ],
)
@pytest.mark.ill_typed
def test_what_cannot_be_drawn_is_refused_in_one_line(setting: Any, message: str):
    with pytest.raises(ValueError, match=f"^{re.escape(message)}"):
        hb.Sampled(**setting)


@pytest.mark.parametrize("measure", MEASURES)
@pytest.mark.parametrize("method", ["guess", None, hb.Exact, 3], ids=str)
@pytest.mark.ill_typed
def test_what_is_no_method_is_refused_by_every_measure(measure: str, method: Any):
    with pytest.raises(ValueError, match=r"^method is .*; use hb\.Exact\(\)"):
        MEASURES[measure](method=method)


@pytest.mark.parametrize("measure", MEASURES)
def test_an_unknown_keyword_is_refused_by_every_measure(measure: str):
    with pytest.raises(TypeError, match="unexpected keyword argument 'samplse'"):
        MEASURES[measure](samplse=3)


def test_methods_are_values():
    assert hb.Exact() == hb.Exact(1e-6, 8, 3600, None)
    assert hb.Sampled() == hb.Sampled(1000, 0)
    assert len({hb.Exact(), hb.Exact(), hb.Sampled(), hb.Sampled(seed=1)}) == 3
    with pytest.raises(AttributeError):
        hb.Exact().tolerance = 1  # pyright: ignore[reportAttributeAccessIssue]


def test_a_method_sets_what_is_computed():
    exact = hb.empowerment(NOISY, 2, "object")
    some = hb.empowerment(NOISY, 2, "object", method=hb.Sampled(3))
    assert (some <= exact + 1e-6).all()
    assert (some < exact - 1e-6).any()
    with pytest.raises(ValueError, match="the limits are 8 GiB and 1e-09 s"):
        hb.empowerment(NOISY, 40, "object", method=hb.Exact(max_seconds=1e-9))


# Keywords of before, for one release


EXACT = {"max_gib": 7.0, "max_seconds": 60.0, "tolerance": 1e-3}
SAMPLED = {"method": "sampled", "samples": 9, "seed": 3}
KEYWORDS = [
    *((name, EXACT, hb.Exact(1e-3, 7.0, 60.0)) for name in MEASURES),
    *((name, SAMPLED, hb.Sampled(9, 3)) for name in MEASURES if name != "futures"),
    ("empowerment", {"tolerance": 1e-3}, hb.Exact(tolerance=1e-3)),
    ("empowerment", {"threads": 2, "samples": 9}, hb.Exact(threads=2)),
    ("empowerment", {"method": "exact"}, hb.Exact()),
    ("empowerment", {"method": "sampled", "threads": 2}, hb.Sampled(threads=2)),
]


@pytest.mark.parametrize(("measure", "keywords", "method"), KEYWORDS)
def test_keywords_of_a_method_still_work_and_their_replacement_is_named(
    measure: str, keywords: Any, method: Any
):
    with pytest.warns(DeprecationWarning, match=f"of {measure} (is|are) deprecated") as reported:
        before = MEASURES[measure](**keywords)
    (warning,) = reported
    message = str(warning.message)
    assert all(f"{name}=" in message for name in keywords)
    suggested = re.fullmatch(r".*; give method=hb\.(.*)", message)
    assert suggested is not None
    assert eval(suggested[1], {"Exact": hb.Exact, "Sampled": hb.Sampled}) == method
    np.testing.assert_equal(before, MEASURES[measure](method=method))


@pytest.mark.parametrize("measure", MEASURES)
def test_a_setting_beside_a_method_is_refused(measure: str):
    with pytest.raises(ValueError, match=r"^max_gib given beside a method; .*Exact\(max_gib=2\)$"):
        MEASURES[measure](method=hb.Exact(), max_gib=2)


def test_a_measure_of_an_environment_takes_either(tmp_path: Path):
    def bits(**options: Any) -> Any:
        measures = {"toe": {"horizon": 2, "sensor": "object", **options}}
        env = gymnasium.make("habilis/World-v0", world=WORLD, slip=0.2, measures=measures)
        return env.reset(seed=0)[1]["toe"]

    some = bits(method=hb.Sampled(samples=2))
    with pytest.warns(DeprecationWarning, match=r"of measures are deprecated"):
        assert bits(method="sampled", samples=2) == some
    assert some < bits()


def test_warnings_point_to_the_line_of_the_user(tmp_path: Path):
    file = tmp_path / "mine.py"
    file.write_text(
        "import habilis as hb\n"
        "mdp = hb.TabularMDP.deterministic([[0, 1], [1, 0]]).slippery(0.2)\n"
        "hb.landscape(hb.World.parse('A.CG'), 1, max_gib=2)\n"
        "hb.empowerment(mdp, 2, method=hb.Exact(tolerance=1e-18))\n"
    )
    done = subprocess.run(
        [sys.executable, "-W", "always", str(file)], stderr=subprocess.PIPE, text=True, check=True
    )
    lines = re.findall(r".*(?:Deprecation|Convergence)Warning: ", done.stderr)
    assert [line.rpartition("/")[2].partition(": ")[0] for line in lines] == [
        "mine.py:3",
        "mine.py:4",
    ]


# Sampled


@settings(max_examples=60, deadline=None)
@given(labelled_tables(), st.integers(0, 5), st.integers(1, 40), st.integers(0, 9))
def test_what_is_sampled_of_a_deterministic_table_is_never_above_the_exact_value(
    drawn: Any, horizon: int, samples: int, seed: int
):
    table, labels = drawn
    mdp = hb.TabularMDP.deterministic(table)
    exact, method = hb.empowerment(mdp, horizon, labels), hb.Sampled(samples, seed)
    some, gap = hb.empowerment(mdp, horizon, labels, method=method, return_gap=True)
    assert (some <= exact + 1e-9).all()
    assert (exact <= some + gap + 1e-9).all()
    again = hb.empowerment(mdp, horizon, labels, method=hb.Sampled(samples, seed))
    np.testing.assert_array_equal(some, again)


@settings(max_examples=30, deadline=None)
@given(labelled_tables(most_actions=2), st.integers(0, 3), st.integers(0, 9))
def test_it_is_the_exact_value_where_all_sequences_are_sampled(drawn: Any, horizon: int, seed: int):
    """2,000 draws miss one of eight sequences with a probability below 1e-100."""
    table, labels = drawn
    mdp = hb.TabularMDP.deterministic(table)
    some = hb.empowerment(mdp, horizon, labels, method=hb.Sampled(2_000, seed))
    np.testing.assert_allclose(some, hb.empowerment(mdp, horizon, labels), atol=1e-9)


def test_a_sampled_count_is_that_of_the_observations_that_samples_lead_to():
    # Two steps on a line from its middle: left-left, right-right, or back.
    line = hb.TabularMDP.deterministic([[max(s - 1, 0), min(s + 1, 4)] for s in range(5)])
    found = {
        float(hb.empowerment(line, 2, states=[2], method=hb.Sampled(2, seed))[0])
        for seed in range(20)
    }
    assert found == {0.0, 1.0}
    assert hb.empowerment(line, 2, states=[2]) == np.log2(3)


def test_no_measure_warns_of_itself():
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        for measure in MEASURES.values():
            measure()
