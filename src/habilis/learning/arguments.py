"""A `Config` from the command line: every field is an option of the same name."""

import argparse
from dataclasses import MISSING, fields

from habilis.learning.config import Config

_NOT_OPTIONS = ("world", "tool")  # arguments of every verb that takes a world


def add_config_arguments(parser: argparse.ArgumentParser) -> None:
    """Adds an option for each field of `Config`."""
    for f in fields(Config):
        if f.name in _NOT_OPTIONS:
            continue
        assert f.default is not MISSING
        shown = ",".join(map(str, f.default)) if f.name == "hidden" else f.default
        parser.add_argument(
            f"--{f.name.replace('_', '-')}",
            type=_widths if f.name == "hidden" else type(f.default),
            default=f.default,
            metavar=f.name.upper(),
            help=f"{f.metadata['help']} (default {shown})",
        )


def config_from_args(args: argparse.Namespace) -> Config:
    """The configuration that the options name.

    Raises:
        ValueError: a value is out of range.
    """
    return Config(**{f.name: getattr(args, f.name) for f in fields(Config)})


def _widths(text: str) -> tuple[int, ...]:
    try:
        return tuple(int(part) for part in text.split(","))
    except ValueError:
        raise argparse.ArgumentTypeError(f"{text!r} is no list of widths, as 64,64") from None
