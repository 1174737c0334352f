"""`habilis completion`: what a shell completes."""

import argparse
from collections.abc import Iterator, Sequence
from contextlib import suppress
from typing import Any

from habilis.benchmarks import BENCHMARKS
from habilis.cli.arguments import Args
from habilis.cli.output import print_json
from habilis.extras import MissingExtraError
from habilis.worlds.tools import TOOLS
from habilis.worlds.world import NO_TOOL, world_names

HELP: str = "print what completes commands in a shell"
EXAMPLE: str = "habilis completion bash"
COMMON: tuple[str, ...] = ()

SHELLS = ("bash", "zsh", "fish")
_TOOLS = (*TOOLS, NO_TOOL)
_SENSORS = ("state", "rest", "agent", "tool", "object")
_FILES = ("SPEC.toml", "F.png", "F.csv", "F.gif", "F.mp4")
_FOLDERS = ("DIR", "RUN")
# Words that may stand for an option or argument, and whether files may, too.
_BY_METAVAR = {"TOOL": (_TOOLS, True), "A,B,...": (_TOOLS, True), "WHAT": (BENCHMARKS, False)}
_BY_NAME = {
    "name": (None, True),  # of a world
    "world": (None, True),
    "begin": (None, True),
    "sensor": (_SENSORS, False),
    "actions": (("all", "moves", "tool"), False),
    "intrinsic": (("none", *_SENSORS, "count", "rnd"), False),
    "names": (("choosing", "two-goals", "unseen"), False),
    "stated": (("corridor", "yard", "yard-apart"), True),
}


def add_arguments(parser: argparse.ArgumentParser) -> None:
    text = (
        'bash (eval "$(habilis completion bash)" in ~/.bashrc), zsh (write it to _habilis in a '
        "folder of fpath), or fish (write it to ~/.config/fish/completions/habilis.fish)"
    )
    parser.add_argument("shell", choices=SHELLS, metavar="SHELL", help=text)


def run(args: Args) -> int:
    import shtab

    from habilis.cli import parser

    whole = parser()
    for verb in verbs(whole):
        with suppress(MissingExtraError):  # the options of training without JAX
            verb.complete_now()
        for action in verb._actions:
            if (pattern := _pattern(action)) is not None:
                action.complete = pattern  # pyright: ignore[reportAttributeAccessIssue]
    script = shtab.complete(whole, args.shell)
    if args.json:
        return print_json({"shell": args.shell, "script": script})
    print(script)
    return 0


def verbs(whole: argparse.ArgumentParser) -> Iterator[Any]:
    """The parser of each verb."""
    for action in whole._actions:
        if isinstance(action, argparse._SubParsersAction):
            yield from action.choices.values()


def _pattern(action: argparse.Action) -> Any:
    """How the values of an option or argument are completed, as shtab has it."""
    import shtab

    if action.choices is not None or action.nargs == 0:
        return None
    known = _BY_METAVAR.get(str(action.metavar)) or _BY_NAME.get(action.dest)
    if known is not None:
        words, files = known
        return _words(world_names() if words is None else words, files)
    if action.metavar in _FOLDERS:
        return shtab.DIRECTORY
    return shtab.FILE if action.metavar in _FILES else None


def _words(words: Sequence[str], files: bool) -> dict[str, Any]:
    """Words and, if asked for, files; shtab has either."""
    listed = " ".join(words)
    name = "_habilis_" + "_".join(words).replace("-", "_") + ("_files" if files else "")
    more = "\n  compgen -f -- $1" if files else ""
    also = " 'files:file:_files'" if files else ""
    path = " (__fish_complete_path (commandline -ct))" if files else ""
    return {
        "bash": name,
        "zsh": name,
        "fish": listed + path,
        "preamble": {
            "bash": f'{name}() {{\n  compgen -W "{listed}" -- $1{more}\n}}',
            "zsh": f"{name}() {{\n  _alternative 'words:name:({listed})'{also}\n}}",
        },
    }
