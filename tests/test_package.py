"""Guarantees of importing and installing."""

import re
import subprocess
import sys
from pathlib import Path

import pytest

import habilis as hb

ROOT = Path(__file__).parents[1]


def python(code):
    return subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=True
    ).stdout


def test_importing_does_not_import_what_is_slow_or_optional():
    loaded = python("import habilis, sys; print(*sys.modules)").split()
    slow = {"jax", "numba", "matplotlib", "scipy", "polars", "rich", "equinox", "optax"}
    assert slow.isdisjoint(loaded)


def test_the_exact_half_works_without_jax():
    code = """
import sys
sys.modules["jax"] = None
import habilis as hb
mdp = hb.tabulate(hb.load_world("yard"))
print(hb.empowerment(mdp, 3, "object", states=mdp.flags["equipped"]).mean())
from habilis.cli import main
main(["landscape", "yard", "--horizon", "1"])
"""
    assert python(code).startswith("0.524104")


@pytest.mark.parametrize(
    ("name", "package", "extra"),
    [
        ("hb.train", "jax", "learn"),
        ("hb.A2C", "jax", "learn"),
        ("hb.reproduce", "jax", "learn"),
        ("hb.learning.train", "jax", "learn"),
        ("hb.sweeps.sweep", "jax", "learn"),
        ("hb.sweeps.search", "optuna", "sweep"),
        ("hb.EmpowermentReward", "gymnasium", "gymnasium"),
        ("hb.envs.WorldEnv", "gymnasium", "gymnasium"),
        ("hb.envs.FunctionalEnv", "jax", "learn"),
        ("hb.Counting().fit(hb.estimators.simulators.pendulum(), 1)", "jax", "robots"),
        ("hb.estimators.simulators.MujocoSimulator('<mujoco/>')", "mujoco", "robots"),
        ("hb.estimators.simulators.gymnasium_simulator('Pusher-v5')", "gymnasium", "robots"),
    ],
)
def test_a_public_name_whose_extra_is_missing_says_what_to_install(name, package, extra):
    code = f"""
import sys
sys.modules[{package!r}] = None
import habilis as hb
from habilis.extras import MissingExtraError
try:
    {name}
except MissingExtraError as error:
    print(error)
"""
    assert python(code) == f"{package} is not installed; run: pip install 'habilis[{extra}]'\n"


def test_every_public_name_is_there_and_documented():
    for name in hb.__all__:
        assert getattr(hb, name).__doc__, name
    assert set(hb.__all__) <= set(dir(hb))


def test_empowerment_stays_a_function_when_its_package_is_imported():
    import habilis.analysis.averages
    import habilis.empowerment.sensors  # noqa: F401

    assert callable(hb.empowerment)


@pytest.mark.parametrize("name", ["constraints.txt", "constraints-integration.txt"])
def test_constraints_name_packages_and_versions_only(name):
    for line in (ROOT / name).read_text().splitlines():
        assert re.fullmatch(r"#.*|[\w.-]+==[\w.]+", line), line
        assert "://" not in line


def test_the_integration_tests_see_the_same_versions_but_of_gymnasium():
    ours, apart = (
        dict(re.findall(r"^([\w.-]+)==(.*)$", (ROOT / name).read_text(), re.MULTILINE))
        for name in ("constraints.txt", "constraints-integration.txt")
    )
    differ = {name for name in ours.keys() & apart.keys() if ours[name] != apart[name]}
    assert differ == {"gymnasium"}
    assert len(ours.keys() & apart.keys()) > 30


def test_every_dependency_is_constrained():
    import tomllib

    project = tomllib.loads((ROOT / "pyproject.toml").read_text())["project"]
    extras = project["optional-dependencies"]
    wanted = [*project["dependencies"], *(name for extra in extras.values() for name in extra)]
    pinned = (ROOT / "constraints.txt").read_text().lower()
    for requirement in wanted:
        name = re.split(r"[<>=\[]", requirement)[0].lower()
        assert f"\n{name}==" in pinned, requirement


def test_the_readmes_tables_are_the_checked_in_results():
    import polars as pl

    readme = (ROOT / "README.md").read_text()
    for name in ("table1", "table2"):
        for row in pl.read_csv(ROOT / "docs" / "results" / f"{name}.csv").iter_rows(named=True):
            line = next(x for x in readme.splitlines() if x.startswith(f"| {row['approach']} |"))
            assert f"{row['published_mean']:,.0f} ± {row['published_std']:,.0f}" in line
            assert f"{row['ours_mean']:,.0f} ± {row['ours_std']:,.0f}" in line
            assert f"{row['converged']} of {row['runs']}" in line
            assert f"{row['thirty_mean']:,.0f} ± {row['thirty_std']:,.0f}" in line
            assert f"{row['thirty_converged']} of {row['thirty_runs']}" in line
            if row["ensemble_outcome"]:
                assert f"| {row['thirty_ratio']:.2f} | {row['thirty_outcome']} |" in line
                low, high = row["ensemble_low"], row["ensemble_high"]
                ensemble = f"{row['ensemble_ratio']:.2f} [{low:.2f}, {high:.2f}]"
                assert f"{ensemble}, {row['ensemble_outcome']} |" in line


@pytest.mark.parametrize("listed", ["slow.txt", "long.txt"])
def test_every_slow_test_exists(listed):
    for line in (ROOT / "tests" / listed).read_text("utf-8").splitlines():
        path, _, name = line.partition("[")[0].partition("::")
        text = (ROOT / path).read_text("utf-8") if (ROOT / path).is_file() else ""
        assert (ROOT / path).exists(), line
        assert not name or f"def {name}" in text, line
