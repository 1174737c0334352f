"""The A2C settings of the paper's tables, frozen by the calibration."""

import tomllib
from pathlib import Path
from typing import Any

from habilis.learning.config import Config
from habilis.studies.published import RUNS, Experiment, Row

SETTINGS = Path(__file__).parent / "data" / "settings.toml"

FULL: dict[str, Any] = {"runs": RUNS, "episodes": 200_000, "steps": 30_000_000}
"""Budget of the whole reproduction: about six minutes on two processors."""
QUICK: dict[str, Any] = {"runs": 5, "episodes": 20_000, "steps": 1_500_000}
"""Budget of `--quick`: at most 3 minutes, in which few runs converge."""


def frozen_settings(experiment: Experiment) -> dict[str, Any]:
    """The fields of `Config` that the calibration chose for an experiment."""
    return tomllib.loads(SETTINGS.read_text("utf-8"))[experiment.name]


def row_config(experiment: Experiment, row: Row, budget: dict[str, Any]) -> Config:
    """The configuration of a row of a table: all rows of an experiment share the settings."""
    config = Config.from_dict(frozen_settings(experiment))
    return config.changed(
        world=experiment.world,
        tool=row.tool,
        intrinsic=row.intrinsic,
        horizon=row.horizon,
        beta=row.beta,
        **budget,
    )
