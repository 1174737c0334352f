"""The report with, and without, what is checked in at the paper's pace; nothing is trained."""

import json

import polars as pl
import pytest
from paces import write_pace
from reproductions import reproduction

import habilis.studies.reproduction.reproduce as reproduce_module
from habilis.studies.pace.data import FILES, load_pace
from habilis.studies.paper.published import EXPERIMENTS
from habilis.studies.paper.settings import FAST_MAPS, FULL, QUICK, frozen_settings, row_config


def written(folder, pace):
    found = reproduction(folder, pace, scale=0.05)
    reproduce_module._write(found)
    return found, (folder / "report.html").read_text()


@pytest.fixture(scope="module")
def full(tmp_path_factory):
    folder = tmp_path_factory.mktemp("full")
    return written(folder / "paper", load_pace(write_pace(folder / "pace", ratio=0.8)))


@pytest.fixture(scope="module")
def bare(tmp_path_factory):
    folder = tmp_path_factory.mktemp("bare")
    return written(folder / "paper", load_pace(folder / "nowhere"))


def test_what_is_missing_is_named_and_nothing_stands_in_its_place(bare):
    found, text = bare
    for name, what in FILES.items():
        assert f"{name} ({what.replace(chr(39), '&#39;')})" in text
    assert "<b>Missing:</b>" in text
    assert "no pairs yet" in text
    assert "ensemble's ratio" not in text
    assert not (found.folder / "slowness.svg").exists()
    data = json.loads((found.folder / "numbers.json").read_text())
    assert data["missing"] == list(FILES)
    assert data["settings"] == frozen_settings()
    assert data["ensemble_verdicts"] == {"holds": 0, "undecided": 0, "opposite": 0}


def test_tables_have_more_runs_and_the_ensembles_ratio_with_its_interval_and_verdicts(full):
    found, text = full
    assert "<b>Missing:</b>" not in text
    assert "ours, 30 runs" in text
    for experiment in EXPERIMENTS:
        rows = pl.read_csv(found.folder / f"{experiment.name}.csv")
        for row, printed in zip(rows.iter_rows(named=True), experiment.rows, strict=True):
            assert row["thirty_runs"] == 30
            assert f"{row['thirty_mean']:,.0f} ± {row['thirty_std']:,.0f}" in text
            if printed.vanilla:
                assert row["outcome"] is row["ensemble_outcome"] is row["ensemble_ratio"] is None
                continue
            assert row["ensemble_ratio"] == pytest.approx(0.8, abs=0.08)
            assert row["ensemble_low"] < row["ensemble_ratio"] < row["ensemble_high"] < 1
            assert row["ensemble_ratio_is"] == ("unknown" if printed.tool == "broom" else "exact")
            assert row["ensemble_outcome"] == row["thirty_outcome"] == "holds"
            assert row["ensemble_pairs"] == 5
            low, high = row["ensemble_low"], row["ensemble_high"]
            assert f"{row['ensemble_ratio']:.2f} [{low:.2f}, {high:.2f}]" in text


def test_orders_are_counted_over_the_ensemble_too(full):
    found, text = full
    orders = [claim for claim in found.learned if claim.ensemble is not None]
    assert len(orders) == 7
    words = ", ".join(f"{name} {n}" for name, n in found.ensemble_verdicts.items())
    assert f"the orders of rows over the ensemble: {words}" in text
    assert all("in the ensemble" in claim.found for claim in orders)


def test_the_report_says_what_the_picture_says(full):
    found, text = full
    assert [(one.measure, one.by) for one in found.associations] == [
        (measure, by) for measure in ("first success", "convergence") for by in ("ratio", "order")
    ]
    for one in found.associations:
        assert f"over {one.learners} learners" in text
    assert text.count("the hypothesis") + text.count("the opposite of the hypothesis") >= 2
    assert (found.folder / "slowness.svg").exists()
    marks = pl.read_csv(found.folder / "slowness.csv")
    assert len(marks) == len(found.pace.learners) * 4 * 2


def test_the_method_describes_prototypes_design_freeze_and_later_decisions(full, bare):
    for _, text in (full, bare):
        assert "Prototypes of this study existed before" in text
        assert "regularised rows included" in text
    text = full[1]
    assert "Screening: 12 settings on 2 maps each, 5 runs of each vanilla agent." in text
    assert "frozen in a commit before any agent with intrinsic reward" in text
    assert "<li>The budget of the broom was doubled.</li>" in text
    assert "The list is missing (after.toml)" in bare[1]


def test_the_tables_learner_is_the_best_pairs_on_its_maps(full):
    found, text = full
    pair = found.pace.best
    assert found.as_data()["settings"] == pair.learner
    assert "Table I, world corridor-01<" in text
    assert [world.name for world in found.other_worlds] == ["corridor-01", "yard-01"]
    assert (found.folder / "yard-01.svg").exists()
    for experiment in EXPERIMENTS:
        for row in experiment.rows:
            config = row_config(experiment, row, QUICK, pair)
            values = config.as_dict()
            assert {name: values[name] for name in pair.learner} == dict(pair.learner)
            assert str(config.world).endswith(f"{pair.maps[experiment.name]}.txt")


def test_without_pairs_the_fast_learner_is_on_the_maps_it_was_calibrated_on():
    for experiment in EXPERIMENTS:
        config = row_config(experiment, experiment.rows[0], FULL)
        assert config.world == FAST_MAPS[experiment.name]
        assert config.as_dict()["optimizer"] == frozen_settings()["optimizer"]


def test_one_colour_scale_has_both_panels_of_figure_4b(bare):
    svg = (bare[0].folder / "figure4b.svg").read_text()
    assert "1-step TOE, picker" in svg
    assert "1-step TOE, broom" in svg
