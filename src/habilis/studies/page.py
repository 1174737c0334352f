"""Pages that need nothing else: templates, with the pictures in them."""

import re
from pathlib import Path
from typing import Any

from jinja2 import (
    ChoiceLoader,
    Environment,
    FileSystemLoader,
    PackageLoader,
    StrictUndefined,
    select_autoescape,
)
from markupsafe import Markup


def render(template: str, folder: Path | None = None, **values: Any) -> str:
    """A page of `templates`, or of a folder whose templates may include those.

    Args:
        template: the name of its file.
        folder: of further templates.
        values: what the page shows.
    """
    folders = [] if folder is None else [FileSystemLoader(folder)]
    environment = Environment(
        loader=ChoiceLoader([*folders, PackageLoader("habilis.studies")]),
        autoescape=select_autoescape(),
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.filters["episodes"] = lambda value: "–" if value is None else f"{value:,.0f}"
    return environment.get_template(template).render(**values)


def inlined(path: Path) -> Markup:
    """An SVG file as part of a page.

    Its ids are made its own, as pages may have each id once; its width in pixels becomes the
    property `--natural`, by which the style keeps labels readable on narrow screens.
    """
    svg = path.read_text("utf-8")
    svg = svg[svg.index("<svg") :]
    for prefix in ('id="', 'href="#', "url(#"):
        svg = svg.replace(prefix, f"{prefix}{path.stem}-")
    points = re.match(r'<svg[^>]*? width="([\d.]+)pt"', svg)
    if points is not None:
        natural = round(float(points[1]) * 96 / 72)
        svg = svg.replace("<svg ", f'<svg style="--natural: {natural}px" ', 1)
    return Markup(svg)  # drawn by us, so safe
