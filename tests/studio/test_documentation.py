"""The studio's documentation agrees with the studio."""

import re
from pathlib import Path

import pytest

from habilis.studio import limits, messages
from habilis.studio.scene_requests import Pools
from habilis.studio.scenes import _DEFAULTS, ACTIONS, SENSORS
from habilis.studio.security import Access
from habilis.studio.server import Studio
from habilis.studio.training_jobs import Trainings

ROOT = Path(__file__).parents[2]
GUIDE = (ROOT / "docs" / "how-to" / "studio.md").read_text("utf-8")
PROTOCOL = messages.__doc__ or ""


def words(text: str) -> set[str]:
    return set(re.findall(r"\w+", text))


@pytest.mark.parametrize(
    ("what", "most"),
    [
        ("rows, and columns, of a map (at least 4)", limits.SIDES[1]),
        ("tools, and objects, of a map", limits.THINGS),
        ("steps ahead", limits.HORIZON),
        ("slip", f"{limits.SLIP:.0%}".replace("%", " %")),
        ("seconds of one computation, by an estimate or else by the clock", f"{limits.SECONDS:g}"),
        ("GiB of memory of one computation", f"{limits.GIB:g}"),
        ("placements that an average is estimated from", limits.DRAWN),
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


def test_the_least_side_is_the_guides_and_the_protocols():
    least, most = limits.SIDES
    assert f"(at least {least})" in GUIDE
    assert f"text of {least} to {most} rows and columns" in PROTOCOL
    assert f"to {limits.HORIZON} actions" in PROTOCOL
    assert f"to {limits.SLIP:g}, the probability" in PROTOCOL


def test_the_protocol_lists_every_request_with_its_fields():
    for name, (required, optional) in messages._FIELDS.items():
        reported = re.search(rf"(?m)^{name} .*(\n {{9}}.*)*", PROTOCOL)
        assert reported is not None, name
        assert {*required, *optional} <= words(reported[0]), name


def test_the_protocol_lists_the_fields_of_a_scene():
    scene = PROTOCOL.partition("A scene is an object:")[2]
    assert set(_DEFAULTS) == set(re.findall(r"(?m)^(\w+)  ", scene))
    assert {*SENSORS, *ACTIONS} <= words(scene)


def test_the_protocol_lists_the_fields_of_the_greeting(tmp_path):
    studio = Studio(Access.of("127.0.0.1", 1), Pools.made(), Trainings(tmp_path))
    assert studio.hello().keys() <= words(PROTOCOL.partition("`hello` has ")[2])
