"""Models for Storm without stormpy; with it, see `tests/integration/test_storm.py`."""

import sys

import pytest

from habilis.extras import MissingExtraError
from habilis.mdp import TabularMDP


def test_without_stormpy_the_extra_is_named(monkeypatch: pytest.MonkeyPatch):
    monkeypatch.setitem(sys.modules, "stormpy", None)
    with pytest.raises(MissingExtraError, match=r"run: pip install 'habilis\[storm\]'"):
        TabularMDP.from_storm("model.nm")
