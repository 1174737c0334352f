import pytest

from habilis.learning.algorithms.ppo import PPO
from habilis.learning.presets import preset
from habilis.sweeps.spec import Range, read_spec


@pytest.fixture
def read(tmp_path):
    def read(text):
        path = tmp_path / "spec.toml"
        path.write_text(text)
        return read_spec(path)

    return read


def test_a_grid_is_every_combination_in_order(read):
    spec = read("""
[config]
world = "yard"
intrinsic = "object"
horizon = 2
runs = 3
[grid]
beta = [0.05, 0.1]
"envs, rollout" = [[8, 10], [16, 5]]
""")
    assert spec.varied == ("beta", "envs", "rollout")
    assert [(c.beta, c.algorithm.envs, c.algorithm.rollout) for c in spec.grid] == [
        (0.05, 8, 10),
        (0.05, 16, 5),
        (0.1, 8, 10),
        (0.1, 16, 5),
    ]
    assert all((c.world, c.runs, c.intrinsic) == ("yard", 3, "object") for c in spec.grid)


def test_an_algorithm_is_a_setting_like_others(read):
    spec = read('[config]\nalgorithm = "ppo"\n[grid]\nhidden = [[64, 64], [32]]\n')
    assert [c.algorithm for c in spec.grid] == [PPO(), PPO(hidden=(32,))]


def test_a_preset_is_what_all_points_share_and_what_is_given_takes_precedence(read):
    spec = read("""
[config]
preset = "book-cartpole"
world = "yard"
envs = 2
[grid]
activation = ["selu", "tanh"]
""")
    common = {"world": "yard", "envs": 2}
    assert spec.varied == ("activation",)
    assert list(spec.grid) == [
        preset("book-cartpole", **common, activation=name) for name in ("selu", "tanh")
    ]


def test_a_search_has_ranges_values_and_its_own_seed(read):
    spec = read("""
[config]
seed = 7
[search]
trials = 12
seed = 5
learning_rate = {low = 1e-4, high = 1e-2, log = true}
rollout = {low = 5, high = 20}
envs = [8, 16]
""")
    assert spec.grid == ()
    assert spec.config == {"seed": 7}
    assert (spec.search.trials, spec.search.seed, spec.search.minimise) == (12, 5, "mean_episodes")
    assert spec.search.space == {
        "learning_rate": Range(1e-4, 1e-2, log=True),
        "rollout": Range(5, 20),
        "envs": [8, 16],
    }


@pytest.mark.parametrize(
    ("text", "fix"),
    [
        (
            "[grid]\nbeat = [0.1]",
            r"\[grid\] has 'beat', which is not a setting; use some of .*beta",
        ),
        ("[config]\nbeat = 0.1\n[grid]\nseed = [0]", r"\[config\] has 'beat'"),
        ('[config]\npreset = "x"\n[grid]\nseed = [0]', "preset 'x' is unknown; use one of book-"),
        ('[grid]\npreset = ["book-cartpole"]', r"\[grid\] has preset.*give it in \[config\]"),
        ("[grid]", r"\[grid\] is empty; give a setting"),
        ("[search]\ntrials = 3", r"\[search\] is empty"),
        ("[grid]\nseed = []", "seed is .*give a list of at least one value"),
        ("[grid]\nseed = 3", "seed is 3; give a list"),
        ("[config]\nruns = 1", r"neither \[grid\] nor \[search\]; give one"),
        ("[grid]\nseed = [1]\n[search]\nenvs = [1]", r"both \[grid\] and \[search\]; give one"),
        ("[grids]\nseed = [1]", r"'grids' is unknown; use \[config\]"),
        ("config = 3", r"config is 3; make it a table, \[config\]"),
        ("[grid]\nbeta = [0.0, 0.1]", "at beta = 0.1: intrinsic is 'none' and beta 0.1"),
        ("[grid]\nlearning_rate = [-1.0]", "at learning_rate = -1.0: .*above 0"),
        ('[grid]\n"envs, rollout" = [[8]]', r"envs, rollout has \[8\]; give lists of 2 values"),
        ('[grid]\nenvs = [8]\n"envs, rollout" = [[8, 5]]', "gives envs twice"),
        ("[config]\nenvs = 4\n[grid]\nenvs = [8]", r"envs is in both \[config\] and \[grid\]"),
        ("[search]\nenvs = {low = 9, high = 8}", "goes from 9 to 8; give low < high"),
        ("[search]\nenvs = {low = 1.5, high = 8}", "low = 1.5; give a whole number"),
        ("[search]\nentropy = {low = 0, high = 1, log = true}", "give a low above 0"),
        ("[search]\nenvs = {low = 1}", "give low, high"),
        ("[search]\noptimizer = {low = 1, high = 2}", "has a range, but is not a number"),
        ("[search]\nenvs = [8]\ntrials = 0", "trials is 0; give at least 1"),
        ("[search]\nenvs = [8]\nat_once = true", "at_once is True; give a whole number"),
        ('[search]\nenvs = [8]\nminimise = "luck"', "minimise 'luck' is unknown; use one of mean_"),
        ("[search]\nbeta = [0.1, 0.2]", "at beta = 0.1: intrinsic is 'none' and beta 0.1"),
        ("[grid", "spec.toml: "),
        ("[grid]\ndiscount = [1979-05-27]", r"\[grid\] has the date 1979-05-27; give a number"),
        ("[config]\ntool = 07:32:00\n[grid]\nseed = [1]", r"\[config\] has the date 07:32:00"),
        ('[search]\nenvs = [8]\nminimise = ["x"]', r"minimise \['x'\] is unknown"),
    ],
)
def test_what_cannot_be_is_refused_in_one_line(read, text, fix):
    with pytest.raises(ValueError, match=fix) as refusal:
        read(text)
    assert "spec.toml: " in str(refusal.value)
    assert "\n" not in str(refusal.value)


def test_a_file_that_is_not_there_is_named(tmp_path):
    with pytest.raises(ValueError, match=r"none.toml: cannot be read \(No such file"):
        read_spec(tmp_path / "none.toml")
