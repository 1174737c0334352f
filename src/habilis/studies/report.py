"""The report: one page that needs nothing else."""

from pathlib import Path

from habilis.files import write_whole
from habilis.studies.outcome import Reproduction
from habilis.studies.page import inlined, render
from habilis.studies.published import EXPERIMENTS
from habilis.studies.settings import frozen_settings
from habilis.studies.tables import comparisons, table


def write_report(reproduction: Reproduction, folder: Path) -> None:
    """Writes `report.html` into the folder that holds the figures, which go into the page."""
    page = render(
        "report.html",
        reproduction=reproduction,
        summary=reproduction.summary(),
        tables=[
            {
                "experiment": experiment,
                "rows": table(experiment, reproduction.results[experiment.name]).to_dicts(),
                "comparisons": comparisons(experiment, reproduction.results[experiment.name]),
            }
            for experiment in EXPERIMENTS
        ],
        settings=frozen_settings(),
        figure=lambda name: inlined(folder / f"{name}.svg"),
    )
    write_whole(folder / "report.html", lambda file: file.write(page.encode()))
