"""The learners of the paper's tables: the fast one, and the headline's at the paper's pace."""

import tomllib
from pathlib import Path
from typing import Any

from habilis.learning.config import Config
from habilis.studies.maps import world_source
from habilis.studies.pace.data import Pair
from habilis.studies.paper.published import RUNS, Experiment, Row

SETTINGS = Path(__file__).parents[1] / "data" / "settings.toml"

FAST_MAPS = {"table1": "corridor", "table2": "yard"}
"""The worlds on which the fast learner was calibrated and acts, by the experiment's name. In
`yard` the can is far from the tool at the start, as the paper's is not: see "Which maps can be
learned" in `docs/explanation/reconstructed.md`."""

FULL: dict[str, Any] = {"runs": RUNS, "episodes": 1_000_000, "steps": 10_000_000}
"""Budget of the whole reproduction: about a minute on two processors."""
QUICK: dict[str, Any] = {"runs": 4, "episodes": 50_000, "steps": 1_200_000}
"""Budget of `--quick`: just enough for the best pair, in as few runs as a rank test needs."""


def frozen_settings() -> dict[str, Any]:
    """The fields of `Config` of the fast learner, the same for all rows of both tables."""
    return tomllib.loads(SETTINGS.read_text("utf-8"))


def learner_settings(pair: Pair | None) -> dict[str, Any]:
    """The fields of `Config` of a pair's learner, or of the fast one where there is no pair."""
    return frozen_settings() if pair is None else dict(pair.learner)


def row_config(
    experiment: Experiment, row: Row, budget: dict[str, Any], pair: Pair | None = None
) -> Config:
    """The configuration of a row of a table.

    Args:
        experiment, row: the table and its row.
        budget: fields of `Config`, such as `FULL`.
        pair: learner and maps; by default the fast learner on its maps.
    """
    world = world_source((FAST_MAPS if pair is None else pair.maps)[experiment.name])
    return Config.from_dict(learner_settings(pair)).changed(
        world=world,
        tool=row.tool,
        intrinsic=row.intrinsic,
        horizon=row.horizon,
        beta=row.beta,
        **budget,
    )
