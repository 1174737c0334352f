"""The report: one page that needs nothing else."""

from pathlib import Path

from jinja2 import Environment, PackageLoader, StrictUndefined, select_autoescape
from markupsafe import Markup

from habilis.studies.outcome import Reproduction
from habilis.studies.published import EXPERIMENTS
from habilis.studies.settings import frozen_settings
from habilis.studies.tables import comparisons, table


def write_report(reproduction: Reproduction, folder: Path) -> None:
    """Writes `report.html` into the folder that holds the figures, which go into the page."""
    environment = Environment(
        loader=PackageLoader("habilis.studies"),
        autoescape=select_autoescape(),
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.filters["episodes"] = lambda value: "–" if value is None else f"{value:,.0f}"
    page = environment.get_template("report.html").render(
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
        figure=lambda name: _inline(folder / f"{name}.svg"),
    )
    (folder / "report.html").write_text(page, "utf-8")


def _inline(path: Path) -> Markup:
    """An SVG file as part of a page; its ids are made its own, as pages may have each id once."""
    svg = path.read_text("utf-8")
    svg = svg[svg.index("<svg") :]
    for prefix in ('id="', 'href="#', "url(#"):
        svg = svg.replace(prefix, f"{prefix}{path.stem}-")
    return Markup(svg)  # drawn by us, so safe
