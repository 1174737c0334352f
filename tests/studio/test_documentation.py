"""The studio's documentation agrees with the studio."""

import re
from pathlib import Path
from typing import get_args

import pytest
from protocol import reference
from studio_protocol import SCHEMA, TYPESCRIPT, schema, typescript

from habilis.studio import limits
from habilis.studio.protocol.answers import ANSWER_OF, Answer
from habilis.studio.protocol.requests import AnyRequest

ROOT = Path(__file__).parents[2]
GUIDE = (ROOT / "docs" / "how-to" / "studio.md").read_text("utf-8")


@pytest.mark.parametrize(
    ("what", "most"),
    [
        ("rows, and columns, of a map (at least 4)", limits.SIDES[1]),
        ("tools, and objects, of a map", limits.THINGS),
        ("steps ahead", limits.HORIZON),
        ("rows, and columns, of a puzzle or environment", limits.BOARD_SIDE),
        ("its factors", limits.FACTORS),
        (
            "its states: of an environment all, of a puzzle those within the horizon",
            f"{limits.BOARD_STATES:,}",
        ),
        ("slip", f"{limits.SLIP:.0%}".replace("%", " %")),
        ("seconds of one computation, by an estimate or else by the clock", f"{limits.SECONDS:g}"),
        ("GiB of memory of one computation", f"{limits.GIB:g}"),
        ("placements of a film", f"{limits.FRAMES:,}"),
        ("placements that an average is estimated from", limits.DRAWN),
        ("placements of a tool with an object under *Which tool?*", f"{limits.PAIR:,}"),
        ("pages at once", limits.CLIENTS),
        ("characters of a message", f"{limits.MESSAGE:,}"),
        ("runs of a training", limits.TRAINING["runs"]),
        ("episodes of a training", f"{limits.TRAINING['episodes']:,}"),
        ("placements of a world to train in", f"{limits.TRAINING['placements']:,}"),
        ("trainings at once", limits.TRAINING["at_once"]),
        ("trainings that wait for that", limits.TRAINING["waiting"]),
        ("kept trainings that a page lists", limits.LISTED),
    ],
)
def test_the_limits_of_the_guide_are_the_studios(what, most):
    assert f"| {what} | {most} |" in GUIDE


def test_the_least_side_is_the_guides():
    assert f"(at least {limits.SIDES[0]})" in GUIDE


def test_the_types_and_the_schema_of_the_page_are_those_of_the_messages():
    fix = "call make protocol, and commit what it writes"
    assert TYPESCRIPT.read_text("utf-8") == typescript(), fix
    assert SCHEMA.read_text("utf-8") == schema(), fix


def test_the_reference_has_every_message_with_its_fields():
    text = reference()
    for request, answer in ANSWER_OF.items():
        part = re.split(r"\n##+ ", text.partition(f"### {request.__struct_config__.tag}\n")[2])[0]
        fields = {*request.__struct_encode_fields__, *answer.__struct_encode_fields__}
        assert fields - set(Answer.__struct_fields__) == set(re.findall(r"(?m)^\| `(\w+)` ", part))
    assert set(re.findall(r"\(#(\w+)\)", text)) <= {
        name.lower() for name in re.findall(r"(?m)^#+ (\w+)$", text)
    }


def test_every_request_has_an_answer():
    assert set(ANSWER_OF) == set(get_args(AnyRequest))
