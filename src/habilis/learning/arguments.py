"""A `Config` from the command line: every field, its algorithm's too, is an option."""

import argparse
from dataclasses import Field, fields
from typing import Any

from habilis.learning.algorithms import ALGORITHMS
from habilis.learning.config import DEFAULT, Config
from habilis.learning.presets import PRESETS, with_preset

_NOT_OPTIONS = ("world", "tool", "algorithm")  # the first two are arguments of many verbs


def add_config_arguments(parser: argparse.ArgumentParser) -> None:
    """Adds an option for each field of `Config` and of the algorithms, and the presets."""
    parser.add_argument(
        "--preset",
        choices=tuple(PRESETS),
        help="a published learner (Graesser and Keng 2019), whose settings take the place of the "
        "defaults below; options given besides take precedence",
    )
    for f in fields(Config):
        if f.name == "algorithm":
            parser.add_argument(
                "--algorithm",
                choices=tuple(ALGORITHMS),
                default=argparse.SUPPRESS,
                help=f"how the agent learns (default {DEFAULT})",
            )
        elif f.name not in _NOT_OPTIONS:
            _add(parser, f, f"default {_shown(f.default)}")
    group = parser.add_argument_group("settings of the algorithm")
    of_algorithms: dict[str, tuple[Field, dict[str, str]]] = {}
    for name, kind in ALGORITHMS.items():
        for f in fields(kind):
            first, defaults = of_algorithms.setdefault(f.name, (f, {}))
            if type(f.default) is not type(first.default):
                raise ValueError(
                    f"algorithm {name!r}: {f.name} is of another type in {next(iter(defaults))}; "
                    "rename it"
                )
            defaults[name] = _shown(f.default)
    for f, defaults in of_algorithms.values():
        by_default: dict[str, list[str]] = {}
        for name, default in defaults.items():
            by_default.setdefault(default, []).append(name)
        listed = "; ".join(f"{', '.join(names)}: {value}" for value, names in by_default.items())
        _add(group, f, listed)


def config_from_args(args: argparse.Namespace) -> Config:
    """The configuration that the options name.

    Raises:
        ValueError: a value is out of range, or no setting of the algorithm.
    """
    known = {f.name for kind in (Config, *ALGORITHMS.values()) for f in fields(kind)}
    given = {name: value for name, value in vars(args).items() if name in known}
    return Config.from_dict(given if args.preset is None else with_preset(args.preset, given))


def _add(parser: Any, f: Field, defaults: str) -> None:
    wanted: Any = type(f.default)
    kind: dict[str, Any] = {"type": wanted, "metavar": f.name.upper()}
    if wanted is bool:
        kind = {"action": argparse.BooleanOptionalAction}
    elif f.name == "hidden":
        kind["type"] = _widths
    parser.add_argument(
        f"--{f.name.replace('_', '-')}",
        default=argparse.SUPPRESS,
        help=f"{f.metadata['help']} ({defaults})".replace("%", "%%"),
        **kind,
    )


def _shown(value: Any) -> str:
    return ",".join(map(str, value)) if isinstance(value, tuple) else str(value)


def _widths(text: str) -> tuple[int, ...]:
    try:
        return tuple(int(part) for part in text.split(","))
    except ValueError:
        raise argparse.ArgumentTypeError(
            f"{text!r} is not a list of widths such as 64,64"
        ) from None
