"""Public empowerment code beside exact values."""

from pathlib import Path

import polars as pl
import pytest

import habilis as hb
from research import other_code

PAGE = Path(__file__).parents[2] / "docs" / "explanation" / "other-code.md"


def test_the_page_shows_the_results_as_they_were_measured():
    assert other_code.as_table(pl.read_csv(other_code.RESULTS)) in PAGE.read_text("utf-8")


def test_a_line_has_the_deviations_and_how_many_are_wrong():
    line = other_code.row("a", "b", [1.0, 2.0, 2.5, 3.0], [1.0, 2.0, 3.0, 3.0005])
    assert (line["least_error"], line["wrong"]) == (-0.5, 0.25)


@pytest.mark.parametrize("name", other_code.CHANNELS)
def test_the_channels_have_their_closed_form_capacities(name):
    known = {
        "binary symmetric, 0.1": 0.531004,
        "binary symmetric, 0.3": 0.118709,
        "Z, 0.5": 0.321928,
        "erasure, 0.5": 0.5,
    }
    assert hb.capacity(other_code.CHANNELS[name]).bits == pytest.approx(known[name], abs=1e-6)
