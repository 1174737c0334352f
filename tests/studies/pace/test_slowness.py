"""Whether slow learners are helped more than fast ones."""

import numpy as np
import pytest
from paces import write_pace
from scipy.stats import spearmanr

from habilis.studies.comparison import Outcome
from habilis.studies.pace import slowness
from habilis.studies.pace.data import MEASURES, AgentRuns, Learner, load_pace
from habilis.studies.paper.published import EXPERIMENTS, REWARDS
from habilis.studies.reproduction.figures import slowness_figure

MAPS = {"table1": "corridor", "table2": "yard"}


def learner(name, pace, ratio, noise=0.05, seed=0, runs=10):
    """A learner whose vanilla agents take `pace` episodes, and the others `ratio` times as many."""
    random = np.random.default_rng(seed)
    agents = []
    for experiment in EXPERIMENTS:
        for row in experiment.rows:
            mean = pace * (1 if row.vanilla else ratio)
            counts = mean * random.lognormal(0, noise, runs)
            where = (MAPS[experiment.name], row.tool, REWARDS[row.intrinsic])
            measures = {measure: counts for measure in MEASURES}  # noqa: C420
            agents.append(AgentRuns(*where, row.horizon, row.beta, measures, counts))
    return Learner(name, "multiverse", MAPS, tuple(agents))


def learners(ratio_of, count=11, noise=0.05):
    paces = np.geomspace(1_000, 100_000, count)
    return [learner(f"{k}", p, ratio_of(p), noise, seed=k) for k, p in enumerate(paces)]


def test_the_hypothesis_holds_where_slow_learners_are_helped_more_and_is_opposite_where_less():
    for exponent, outcome in ((-0.3, Outcome.HOLDS), (0.3, Outcome.OPPOSITE)):
        many = learners(lambda pace, e=exponent: (pace / 10_000) ** e)
        for by in slowness.WAYS:
            found = slowness.association(many, "convergence", by)
            assert found is not None
            assert found.outcome is outcome
            assert abs(found.middle) > 0.85
            assert found.low <= found.middle <= found.high
            assert (found.learners, found.marks) == (11, 44)


def test_noise_of_the_vanilla_agents_alone_makes_no_correlation():
    """Equal learners, few noisy runs: a plain correlation of ratio and vanilla is far below 0."""
    equal = [learner(f"{k}", 10_000, 1.0, noise=0.8, seed=k, runs=6) for k in range(40)]
    table = slowness.marks(equal).filter(measure="convergence", row="A2C with 6-step TOE")
    assert spearmanr(table["vanilla"], table["ratio"]).statistic < -0.4  # pyright: ignore[reportAttributeAccessIssue]
    for by in slowness.WAYS:
        found = slowness.association(equal, "convergence", by)
        assert found is not None
        assert abs(found.middle) < 0.15
        assert found.outcome is Outcome.UNDECIDED


def test_without_noise_the_correlation_is_spearmans():
    random = np.random.default_rng(2)
    ratios = random.lognormal(0, 0.3, 9)
    paces = random.lognormal(9, 1, 9)
    many = [learner(f"{k}", p, r, noise=0) for k, (p, r) in enumerate(zip(paces, ratios))]  # noqa: B905
    found = slowness.association(many, "first success")
    assert found is not None
    assert found.middle == pytest.approx(spearmanr(paces, ratios).statistic)  # pyright: ignore[reportAttributeAccessIssue]
    assert found.below == 4 * (ratios < 1).sum()


def test_by_order_learners_that_never_converge_are_the_slowest_however_few_their_episodes():
    """Those that never converge without the bonus always do with it: it helps the slow ones."""

    def hovering(name, seed):
        one = learner(name, 20_000, 1.0, seed=seed)
        never = {m: np.full(10, np.inf) for m in MEASURES}
        agents = tuple(
            AgentRuns(*(a.map, a.tool, a.reward, a.horizon, a.beta), never, np.full(10, 4_000.0))
            if a.reward == "none"
            else a
            for a in one.agents
        )
        return Learner(name, one.source, one.maps, agents)

    many = [*learners(lambda pace: 1.5, count=6), *(hovering(f"h{k}", k) for k in range(6))]
    by_order = slowness.association(many, "convergence", "order")
    assert by_order is not None
    assert by_order.outcome is Outcome.HOLDS
    by_ratio = slowness.association(many, "convergence", "ratio")
    assert by_ratio is not None
    assert by_ratio.outcome is not Outcome.HOLDS, "by few long episodes they pass for fast"


def test_rows_of_different_pace_do_not_pretend_that_learners_differ():
    """The broom's rows slow and helped, the picker's neither, by every learner alike."""
    many = learners(lambda pace: 1.0, noise=0.1)
    agents = [
        tuple(
            AgentRuns(
                *(a.map, a.tool, a.reward, a.horizon, a.beta),
                {m: c * factor for m, c in a.counts.items()},
                a.had * factor,
            )
            for a in one.agents
            for factor in [
                {("broom", "none"): 100.0, ("broom", "TOE"): 10.0}.get((a.tool, a.reward), 1.0)
            ]
        )
        for one in many
    ]
    many = [Learner(o.name, o.source, o.maps, a) for o, a in zip(many, agents, strict=True)]
    found = slowness.association(many, "convergence")
    assert found is not None
    assert found.outcome is Outcome.UNDECIDED


def test_too_few_learners_and_those_without_all_rows_say_nothing():
    few = learners(lambda pace: 1.0, count=3)
    assert slowness.association(few, "convergence") is None
    part = Learner("part", "ensemble", MAPS, few[0].agents[:2])
    assert slowness.association([*few, part], "convergence") is None


def test_a_sentence_says_which_of_the_three_it_is():
    words = {-0.3: "the hypothesis holds", 0.3: "the opposite of the hypothesis comes out"}
    for exponent, expected in words.items():
        many = learners(lambda pace, e=exponent: (pace / 10_000) ** e)
        found = slowness.association(many, "first success")
        assert found is not None
        assert expected in slowness.sentence(found)
        assert "By episodes to first success, over 11 learners" in slowness.sentence(found)


def test_there_is_a_mark_for_each_learner_and_row_in_both_panels(tmp_path):
    pace = load_pace(write_pace(tmp_path, ratio=0.8))
    marks = slowness.marks(pace.learners)
    assert len(marks) == len(pace.learners) * 4 * 2
    assert marks["ratio"].to_numpy() == pytest.approx(0.8, rel=0.2)
    broom = marks.filter(row="A2C with 3-step TOE (broom)", measure="convergence")
    assert not broom["complete"].any(), "one run of each exceeded its budget"
    assert marks.filter(measure="first success")["complete"].all()
    figure = slowness_figure(marks)
    panels = figure.axes
    assert [ax.get_title() for ax in panels] == list(MEASURES)
    for ax in panels:
        points = [line for line in ax.lines if line.get_linestyle() == "None"]
        assert len(points) == len(pace.learners) * 4
        assert (ax.get_xscale(), ax.get_yscale()) == ("log", "log")
        assert any(np.array_equal(line.get_ydata(), [1, 1]) for line in ax.lines), "a line at 1"
