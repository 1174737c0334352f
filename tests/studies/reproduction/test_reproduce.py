"""The report, end to end, in a tiny configuration."""

import json
import shutil
from dataclasses import replace as dataclass_replace
from html.parser import HTMLParser
from pathlib import Path

import polars as pl
import pytest

import habilis as hb
import habilis.studies.reproduction.reproduce as reproduce_module
from habilis.studies.paper.published import EXPERIMENTS
from habilis.studies.paper.settings import FULL, frozen_settings, row_config

TINY = {"runs": 2, "episodes": 2_500, "steps": 40_000}


@pytest.fixture(scope="module")
def paper(tmp_path_factory):
    return hb.reproduce(tmp_path_factory.mktemp("out") / "paper", budget=TINY)


class Page(HTMLParser):
    """The resources of a page, its ids, and the targets of its links."""

    def __init__(self, text):
        super().__init__()
        self.loads, self.ids, self.links = [], [], []
        self.feed(text)

    def handle_starttag(self, tag, attrs):
        for name, value in attrs:
            if name == "id":
                self.ids.append(value)
            elif name in ("src", "href", "xlink:href") and value:
                (self.links if value.startswith("#") else self.loads).append(value)


def test_one_folder_has_the_whole_paper(paper):
    names = {path.name for path in paper.folder.iterdir()}
    assert names >= {"report.html", "numbers.json", "table1.csv", "table2.csv"}
    assert names >= {f"figure{n}.svg" for n in ("1", "2", "3", "4a", "4b")}
    assert not list(paper.folder.parent.glob(".*")), "nothing half-written is left"


def test_the_report_is_one_page_that_loads_nothing(paper):
    text = (paper.folder / "report.html").read_text()
    page = Page(text)
    assert page.loads == []
    assert "url(http" not in text
    assert "@import" not in text
    assert len(page.ids) == len(set(page.ids))
    assert {link[1:] for link in page.links} <= set(page.ids)
    pictures = 9 + len(paper.other_worlds) + bool(paper.pace.learners)
    assert text.count("<svg") == pictures


def test_the_report_shows_every_number_statement_and_row(paper):
    text = (paper.folder / "report.html").read_text().replace("&#34;", '"').replace("&#39;", "'")
    for number in paper.numbers:
        assert number.text in text
    for relation in [*paper.relations, *paper.learned]:
        assert relation.text in text
    for experiment in EXPERIMENTS:
        for row in experiment.rows:
            assert f"{row.mean:,.0f}" in text
    assert "reconstructions" in text


def test_the_data_say_what_the_report_says(paper):
    data = json.loads((paper.folder / "numbers.json").read_text())
    assert len(data["numbers"]) == len(paper.numbers)
    assert all(number["agrees"] for number in data["numbers"])
    for experiment in EXPERIMENTS:
        rows = pl.read_csv(paper.folder / f"{experiment.name}.csv")
        assert rows["approach"].to_list() == [row.label for row in experiment.rows]
        assert rows["published_mean"].to_list() == [row.mean for row in experiment.rows]
        assert data["tables"][experiment.name]["rows"] == rows.to_dicts()
        for i, result in enumerate(paper.results[experiment.name]):
            saved = pl.read_parquet(paper.folder / f"{experiment.name}-row{i + 1}.parquet")
            assert saved.equals(result.run.episodes)


class Cells(HTMLParser):
    """The texts of a page's table rows."""

    def __init__(self, text):
        super().__init__()
        self.rows, self.inside = [], False
        self.feed(text)

    def handle_starttag(self, tag, attrs):
        if tag == "tr":
            self.rows.append([])
        self.inside = self.inside or tag == "td"
        if tag == "td":
            self.rows[-1].append("")

    def handle_endtag(self, tag):
        self.inside = self.inside and tag != "td"

    def handle_data(self, data):
        if self.inside:
            self.rows[-1][-1] += data


def test_the_reports_tables_show_the_data(paper):
    rows = Cells((paper.folder / "report.html").read_text()).rows
    shown = {row[1]: row for row in rows if len(row) > 1}
    data = json.loads((paper.folder / "numbers.json").read_text())
    for number in data["numbers"]:
        row = shown[number["text"]]
        assert row[2] == number["published"]
        assert float(row[3]) == pytest.approx(number["ours"], abs=5e-5)
        assert row[5] == ("agrees" if number["agrees"] else "differs")
    for relation in data["relations"]:
        row = shown[relation["text"]]
        assert row[2] == ("holds" if relation["holds"] else "does not hold")
        assert row[3] == relation["found"]
    for claim in data["learned"]:
        row = shown[claim["text"]]
        assert row[2] == claim["outcome"]
        assert row[3] == claim["found"]
    by_label = {row[0]: row for row in rows if len(row) >= 8 and "±" in row[1]}
    for table in data["tables"].values():
        for result in table["rows"]:
            row = by_label[result["approach"]]
            assert f"{result['published_mean']:,.0f}" in row[1]
            assert f"{result['ours_mean']:,.0f} ± {result['ours_std']:,.0f}" in row[3]
            assert float(row[4].strip("? ")) == pytest.approx(result["ours_ratio"], abs=5e-3)
            assert row[5] == "–", "all runs exceeded their budget"
            assert result["ours_median"] is None
            assert row[6] == f"{result['converged']} of {result['runs']}"
            assert row[7] == (result["outcome"] or "")


def test_card_summary_and_data_count_the_claims_about_agents_in_three_values(paper):
    data = json.loads((paper.folder / "numbers.json").read_text())
    outcomes = [claim["outcome"] for claim in data["learned"]]
    assert data["verdicts"] == {
        value: outcomes.count(value) for value in ("holds", "undecided", "opposite")
    }
    assert sum(data["verdicts"].values()) == len(paper.learned) == paper.summary()["learned"]
    words = ", ".join(f"{value} {n}" for value, n in data["verdicts"].items())
    assert f"statements about the learning agents: {words}" in paper.text()
    assert f"<b>{words}</b>" in (paper.folder / "report.html").read_text()
    kinds = ("hold", "undecided", "opposite")
    assert [paper.summary()[f"learned_{kind}"] for kind in kinds] == [*data["verdicts"].values()]


def test_runs_that_exceeded_their_budget_are_shown_as_lower_bounds(paper):
    rows = pl.read_csv(paper.folder / "table1.csv")
    assert rows["mean_is_lower_bound"].all()
    assert (rows["converged"] == 0).all()
    assert (paper.folder / "report.html").read_text().count("≥ ") >= 3


def test_a_folder_with_other_things_is_refused_before_any_work(tmp_path):
    (tmp_path / "thesis.tex").write_text("years of work")
    with pytest.raises(ValueError, match="not an earlier reproduction; name a new folder"):
        hb.reproduce(tmp_path, budget=TINY)
    (tmp_path / "numbers.json").write_text('{"habilis": "0"}')
    with pytest.raises(ValueError, match="not an earlier reproduction"):
        hb.reproduce(tmp_path, budget=TINY)
    (tmp_path / "link").symlink_to(tmp_path)
    with pytest.raises(ValueError, match="is a link"):
        hb.reproduce(tmp_path / "link", budget=TINY)
    with pytest.raises(ValueError, match="is not a folder"):
        hb.reproduce(tmp_path / "thesis.tex" / "paper", budget=TINY)
    assert (tmp_path / "thesis.tex").read_text() == "years of work"


def test_an_earlier_reproduction_is_replaced(paper, tmp_path):
    folder = tmp_path / "paper"
    shutil.copytree(paper.folder, folder)
    (folder / "table1.csv").write_text("old")
    reproduce_module._check_replaceable(folder)
    reproduce_module._write(dataclass_replace(paper, folder=folder))
    assert (folder / "table1.csv").read_text() == (paper.folder / "table1.csv").read_text()
    assert [path.name for path in tmp_path.iterdir()] == ["paper"]


def test_all_rows_share_the_frozen_settings():
    settings = frozen_settings()
    for experiment in EXPERIMENTS:
        for row in experiment.rows:
            config = row_config(experiment, row, FULL)
            values = config.as_dict()
            assert {name: values[name] for name in settings} == settings
            assert (config.intrinsic, config.beta) == (row.intrinsic, row.beta)
            assert config.runs == 10


def test_an_earlier_folder_stays_where_a_new_one_cannot_take_its_place(tmp_path, monkeypatch):
    new, out = tmp_path / ".new", tmp_path / "paper"
    for folder, text in ((new, "new"), (out, "earlier")):
        folder.mkdir()
        (folder / "numbers.json").write_text(text)
    rename = Path.rename

    def fails(path, target):
        if path == new:
            raise OSError(28, "No space left on device")
        return rename(path, target)

    with monkeypatch.context() as patched:
        patched.setattr(Path, "rename", fails)
        with pytest.raises(OSError, match="No space left"):
            reproduce_module._put_in_place(new, out)
    assert (out / "numbers.json").read_text() == "earlier"
    assert (new / "numbers.json").read_text() == "new"
    reproduce_module._put_in_place(new, out)
    assert (out / "numbers.json").read_text() == "new"
    assert [path.name for path in tmp_path.iterdir()] == ["paper"]
