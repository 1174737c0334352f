"""Tables of benchmarks, from the files that `python -m research.performance` writes."""

import csv
import re
from itertools import groupby
from pathlib import Path
from typing import Any

from mkdocs.exceptions import PluginError
from mkdocs.structure.pages import Page

from habilis.benchmarks.growth import AXES, Point, is_exponential, slope

RESULTS = Path(__file__).parents[2] / "research" / "results"
_TABLE = re.compile(r"<!-- benchmark: (?P<names>[\w, ]+) -->")
_SLOPES, _MACHINE = "<!-- slopes of growth -->", "<!-- the machine of the benchmarks -->"

Row = dict[str, str]


def on_page_markdown(markdown: str, page: Page, **_: Any) -> str:
    """Puts tables where a page asks for them."""
    if _SLOPES in markdown:
        markdown = markdown.replace(_SLOPES, slopes())
    if _MACHINE in markdown:
        markdown = markdown.replace(_MACHINE, machines())
    return _TABLE.sub(lambda found: table(found["names"].split(", ")), markdown)


def table(benchmarks: list[str]) -> str:
    """What some benchmarks found, as a table in Markdown."""
    rows = [row for row in _rows("performance.csv") if row["benchmark"] in benchmarks]
    if missing := set(benchmarks) - {row["benchmark"] for row in rows}:
        raise PluginError(f"{sorted(missing)[0]}: not measured; run python -m research.performance")
    lines = ["| | median | least to most | measured on, or against |", "|---|--:|--:|---|"]
    for row in rows:
        spread = f"{_number(row['least'])} to {_number(row['most'])}" if row["least"] else ""
        value = f"{_number(row['value'])} {row['unit']}"
        lines.append(f"| {row['name'].strip()} | {value} | {spread} | {row['note']} |")
    return "\n".join(lines)


def slopes() -> str:
    """How each curve grows, as a table in Markdown."""
    points = [
        Point(
            row["axis"],
            row["name"],
            int(row["size"]),
            float(row["seconds"]),
            float(row["least"]),
            float(row["most"]),
            float(row["gib"]) if row["gib"] else None,
        )
        for row in _rows("growth.csv")
    ]
    tasks = {axis.name: axis.task for axis in AXES}
    lines = [
        "| grows | | from, to | growth of time | of memory | the largest |",
        "|---|---|--:|--:|--:|---|",
    ]
    for (axis, name), curve in groupby(points, lambda point: (point.axis, point.name)):
        found = list(curve)
        last = found[-1]
        grows = [_growth(axis, slope(found, of)) for of in ("seconds", "gib")]
        memory = "" if last.gib is None else f", {max(last.gib, 0.001):.2g} GiB"
        cells = [
            f"{axis} ({tasks[axis]})" if name == "ours" else axis,
            name,
            f"{found[0].size:,}, {last.size:,}",
            *grows,
            f"{_number(str(last.seconds))} s{memory}",
        ]
        lines.append(f"| {' | '.join(cells)} |")
    return "\n".join(lines)


def machines() -> str:
    """The machines and days of the measurements, each once."""
    rows = [*_rows("performance.csv"), *_rows("growth.csv")]
    found = dict.fromkeys(f"{row['machine']} ({row['date']})" for row in rows)
    return "; ".join(found)


def _rows(file: str) -> list[Row]:
    with (RESULTS / file).open(newline="", encoding="utf-8") as lines:
        return list(csv.DictReader(lines))


def _number(text: str) -> str:
    """Three digits, without an exponent."""
    value = float(text)
    if abs(value) >= 100:
        return f"{value:,.0f}"
    return f"{value:.3g}" if abs(value) >= 1e-3 or value == 0 else f"{value:.1g}"


def _growth(axis: str, value: float | None) -> str:
    if value is None:
        return "–"
    text = f"{value:.2f}".replace("-", "−")
    return f"×{text}" if is_exponential(axis) else text
