"""The command line: a module for each verb, with its arguments and the function that runs it."""

import argparse
import os
import re
import sys
from collections.abc import Collection, Mapping, Sequence
from dataclasses import fields
from typing import Any, NoReturn, Protocol

import habilis
from habilis.cli import (
    bench,
    compare,
    completion,
    empowerment,
    estimators,
    futures,
    landscape,
    plot,
    reconstruct,
    reproduce,
    solve,
    studio,
    study,
    sweep,
    train,
    watch,
    worlds,
)
from habilis.cli.arguments import Args
from habilis.cli.executors import executor_opened
from habilis.cli.output import check_outputs, compiling_announced, refuse
from habilis.empowerment.methods import Sampled
from habilis.extras import MissingExtraError


class Verb(Protocol):
    """A module of this package.

    Attributes:
        HELP: what it does, in half a sentence.
        EXAMPLE: a command that runs.
        COMMON: its options that are used most, in the order in which the help has them.
    """

    HELP: str
    EXAMPLE: str
    COMMON: tuple[str, ...]

    def add_arguments(self, parser: argparse.ArgumentParser, /) -> None:
        """Adds its arguments."""

    def run(self, args: Args, /) -> int:
        """Runs it; returns the exit status."""
        ...


VERBS: dict[str, Verb] = {
    "worlds": worlds,
    "solve": solve,
    "empowerment": empowerment,
    "landscape": landscape,
    "futures": futures,
    "compare": compare,
    "estimators": estimators,
    "train": train,
    "watch": watch,
    "plot": plot,
    "sweep": sweep,
    "reproduce": reproduce,
    "study": study,
    "reconstruct": reconstruct,
    "studio": studio,
    "bench": bench,
    "completion": completion,
}

_ABOUT = "Exact empowerment of finite MDPs, tool-use worlds, and agents that learn with it."
_IN_PYTHON = (
    *("unit", "method", *(f.name for f in fields(Sampled))),  # which has the settings of both
    *("max_states", "key", "state", "ignore", "factors", "starts", "states"),
)
"""Arguments that errors of the library name; a verb may have an option for them or not."""
_QUOTES = "'[]"
_USAGE_WIDTH = 72  # after "usage: "
_METHOD = re.compile(r"hb\.(\w+)\(\)")  # as errors of the library name one


def main(arguments: Sequence[str] | None = None) -> int:
    """Runs one command.

    Returns:
        The exit status: 0 done, 1 the answer is "no" (a goal out of reach, a claim that does
        not hold), 2 bad input.
    """
    flags: dict[str, str] = {}
    lacks: tuple[str, ...] = ()
    try:
        args = parser().parse_args(arguments)
        flags, lacks = args.flags, getattr(args, "lacks", ())
        args.command = list(sys.argv[1:] if arguments is None else arguments)
        check_outputs(args)
        with compiling_announced(args), executor_opened(args):
            status = args.verb(args)
        sys.stdout.flush()
        return status
    except BrokenPipeError:
        # The reader of our output is gone. So that Python does not complain at exit, either:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 0
    except (ValueError, MissingExtraError, FloatingPointError) as error:
        return refuse(in_flags(str(error), flags, lacks))
    except (OSError, OverflowError) as error:
        return refuse(f"{error}; check the place and the numbers given")
    except MemoryError:
        return refuse("not enough memory; make the world or the horizon smaller")
    except KeyboardInterrupt as stop:
        return refuse(str(stop) or "interrupted", status=128 + getattr(stop, "signal", 2))


def parser() -> argparse.ArgumentParser:
    """The parser of the whole command line."""
    whole = _Parser(prog="habilis", description=_ABOUT)
    whole.add_argument("--version", action="version", version=habilis.__version__)
    verbs = whole.add_subparsers(required=True, metavar="VERB", parser_class=_VerbParser)
    for name, verb in VERBS.items():
        added = verbs.add_parser(
            name,
            help=verb.HELP,
            description=verb.HELP[0].upper() + verb.HELP[1:] + ".",
            epilog=f"example: {verb.EXAMPLE}",
        )
        added.pending = verb
    return whole


class _Parser(argparse.ArgumentParser):
    """A parser that reports bad usage in one line, like all other bad input."""

    def error(self, message: str) -> NoReturn:
        raise ValueError(f"{message}; see {self.prog} --help")


class _VerbParser(_Parser):
    """Refuses what a verb does not take itself, so that the line names the help of the verb.

    Attributes:
        pending: the verb, until its arguments are added. That is when they are first needed, since
            the settings of the algorithms, which `train` has, are in modules that import JAX.
    """

    pending: Verb | None = None

    def format_help(self) -> str:
        self.complete_now()
        return super().format_help()

    def complete_now(self) -> None:
        """Adds the arguments of the verb, unless it has them."""
        if self.pending is None:
            return
        verb, self.pending = self.pending, None
        self.add_argument("--json", action="store_true", help="print JSON, for machines")
        verb.add_arguments(self)
        self._put_first(verb.COMMON)
        flags = {a.dest: a.option_strings[0] for a in self._actions if a.option_strings}
        self.set_defaults(verb=verb.run, flags=flags)

    def _put_first(self, common: Sequence[str]) -> None:
        """Has the help begin with the common options, and name no others in its first line."""
        places = {flag: place for place, flag in enumerate(common)}
        general = {"--help": 1, "--json": 1}

        def place(action: argparse.Action) -> tuple[int, int]:
            flag = action.option_strings[-1] if action.option_strings else ""
            return general.get(flag, 0), places.get(flag, len(places))

        options = self._optionals._group_actions
        options.sort(key=place)
        shown = [action for action in options if place(action)[1] < len(places)]
        words = [_usage(action) for action in (*self._positionals._group_actions, *shown)]
        lines = [self.prog]
        for word in (*words, "[options]"):
            if len(lines[-1]) + 1 + len(word) > _USAGE_WIDTH:
                lines.append(" " * len(self.prog))
            lines[-1] += f" {word}"
        self.usage = "\n       ".join(lines)

    def parse_known_args(  # pyright: ignore[reportIncompatibleMethodOverride]
        self, args: Any = None, namespace: Any = None
    ) -> Any:
        self.complete_now()
        found, others = super().parse_known_args(args, namespace)
        if others:
            self.error(f"unrecognized arguments: {' '.join(others)}")
        return found, []


def _usage(action: argparse.Action) -> str:
    """An argument or an option as the first line of the help has it."""
    value = action.metavar or action.dest.upper()
    if not action.option_strings:
        return {"?": f"[{value}]", "*": f"[{value} ...]", "+": f"{value} ..."}.get(
            str(action.nargs), str(value)
        )
    text = action.option_strings[-1] + (f" {value}" if action.nargs != 0 else "")
    return text if action.required else f"[{text}]"


def in_flags(message: str, flags: Mapping[str, str], lacks: Collection[str] = ()) -> str:
    """An error of the library in the command line's terms: arguments by their options.

    Args:
        message: names arguments as Python has them, as in `raise max_gib` and `unit='nats'`.
        flags: the options of the verb, by the names of their arguments.
        lacks: arguments that its function in Python does not have either.

    Example:
        >>> in_flags("slip is 2; give slip=0.1 or raise max_gib", {"slip": "--slip"})
        '--slip is 2; give --slip 0.1 or raise max_gib (in Python)'
    """
    names = sorted({*flags, *_IN_PYTHON}, key=len, reverse=True)
    every, long = "|".join(names), "|".join(name for name in names if "_" in name)
    named = re.compile(
        rf"(?<![\w./-])(?P<given>{every})=(?P<value>'[^']*'|\[[^]]*\]|[\w.]+(?:\(\))?)?"
        rf"|(?<![\w./'-])(?P<long>{long})(?![\w./'=])"
        rf"|(?:^|(?<=: )|(?<=, )|(?<=and )|(?<=but ))(?P<subject>{every})(?= (?:is|has|have) )"
    )

    def said(found: re.Match[str]) -> str:
        name = found["given"] or found["long"] or found["subject"]
        if name in flags:
            value = (found["value"] or "").strip(_QUOTES)
            method = _METHOD.fullmatch(value)
            return f"{flags[name]} {value if method is None else method[1].lower()}".rstrip()
        return found[0] if found["subject"] or name in lacks else f"{found[0]} (in Python)"

    return named.sub(said, message)
