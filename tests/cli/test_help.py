"""Helps begin with the options that are used most, and fit a terminal of 80 columns."""

import re

import pytest

from habilis.cli import VERBS, main

FLAG = re.compile(r"  (?:-\w, )?(--[a-z-]+)")


@pytest.fixture
def shown(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]):
    def help_of(verb: str) -> list[str]:
        monkeypatch.setenv("COLUMNS", "80")
        with pytest.raises(SystemExit):
            main([verb, "--help"])
        return capsys.readouterr().out.splitlines()

    return help_of


@pytest.mark.parametrize("verb", VERBS)
def test_a_help_begins_with_the_common_options_and_ends_with_the_general_ones(verb: str, shown):
    lines = shown(verb)
    begin = lines.index("options:") + 1
    end = next((k for k in range(begin, len(lines)) if not lines[k]), len(lines))
    flags = [flag[1] for line in lines[begin:end] if (flag := FLAG.match(line))]
    common = VERBS[verb].COMMON
    assert len(common) <= 4
    assert flags[: len(common)] == list(common)
    assert flags[-2:] == ["--help", "--json"]


@pytest.mark.parametrize("verb", VERBS)
def test_a_help_fits_80_columns_and_its_first_lines_have_the_common_options(verb: str, shown):
    lines = shown(verb)
    usage = " ".join(lines[: lines.index("")])
    assert usage.startswith(f"usage: habilis {verb}")
    assert usage.endswith("[options]")
    assert all(flag in usage for flag in VERBS[verb].COMMON)
    written_out = "{book-cartpole,book-lander-gae,book-lander-nstep,book-gridworld}"
    assert all(len(line) <= 80 for line in lines if written_out not in line)
