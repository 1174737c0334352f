"""The A2C settings of the paper's tables, frozen by the calibration."""

import tomllib
from pathlib import Path
from typing import Any

from habilis.learning.config import Config
from habilis.studies.published import RUNS, Experiment, Row

SETTINGS = Path(__file__).parent / "data" / "settings.toml"

FULL: dict[str, Any] = {"runs": RUNS, "episodes": 1_000_000, "steps": 10_000_000}
"""Budget of the whole reproduction: about a minute on two processors."""
QUICK: dict[str, Any] = {"runs": 5, "episodes": 20_000, "steps": 300_000}
"""Budget of `--quick`, in which few runs converge."""


def frozen_settings() -> dict[str, Any]:
    """The fields of `Config` that the calibration chose, the same for all rows of both tables."""
    return tomllib.loads(SETTINGS.read_text("utf-8"))


def row_config(experiment: Experiment, row: Row, budget: dict[str, Any]) -> Config:
    """The configuration of a row of a table."""
    return Config.from_dict(frozen_settings()).changed(
        world=experiment.world,
        tool=row.tool,
        intrinsic=row.intrinsic,
        horizon=row.horizon,
        beta=row.beta,
        **budget,
    )
