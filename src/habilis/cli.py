"""The command line: one thin function a verb."""

import argparse
import json
import os
import sys
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any, NoReturn

import numpy as np

import habilis
from habilis.extras import MissingExtraError, import_from
from habilis.worlds.rules import ACTIONS
from habilis.worlds.world import NO_TOOL, Cell, load_world, world_names

Args = argparse.Namespace

_ABOUT = "Exact empowerment of finite MDPs, tool-use worlds, and agents that learn with it."


def main(arguments: Sequence[str] | None = None) -> int:
    """Runs one command.

    Returns:
        The exit status: 0 done, 1 the answer is "no" (a goal out of reach, a claim that does
        not hold), 2 bad input.
    """
    try:
        args = _parser().parse_args(arguments)
        status = args.verb(args)
        sys.stdout.flush()
        return status
    except BrokenPipeError:
        # Whoever reads our output has gone; so that Python does not complain at exit either:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 0
    except (ValueError, MissingExtraError, FloatingPointError) as error:
        return _refuse(str(error))
    except (OSError, OverflowError) as error:
        return _refuse(f"{error}; check the place and the numbers given")
    except MemoryError:
        return _refuse("not enough memory; make the world or the horizon smaller")
    except KeyboardInterrupt:
        return _refuse("interrupted", status=130)


def _refuse(message: str, status: int = 2) -> int:
    print(f"habilis: {message}", file=sys.stderr)
    return status


def worlds(args: Args) -> int:
    if args.name is None:
        if args.tool is not None or args.out is not None:
            raise ValueError("no world to draw; give its name besides --tool or --out")
        listed = [load_world(name) for name in world_names()]
        if args.json:
            return _print_json({"worlds": [world.name for world in listed]})
        for world in listed:
            print(f"{world.name}: {world.height} x {world.width} cells, tool {world.tool}")
        return 0
    world = load_world(args.name, args.tool)
    if args.out is not None:
        from habilis.worlds.pictures import save_picture

        _save(args.out, lambda path: save_picture(world, path))
    if args.json:
        return _print_json(
            {"name": world.name, "height": world.height, "width": world.width}
            | {"tool": world.tool, "map": world.text().splitlines()}
        )
    from habilis.worlds.pictures import colored_text

    _console().print(colored_text(world))
    return 0


def solve(args: Args) -> int:
    plan = habilis.solve(habilis.tabulate(load_world(args.world, args.tool)))
    if args.json:
        _print_json(
            {"steps": None, "return": None, "actions": None}
            if plan is None
            else {"steps": plan.steps, "return": plan.best_return, "actions": list(plan.actions)}
        )
    elif plan is None:
        print("the goal is out of reach")
    else:
        print(f"{plan.steps} steps, return {plan.best_return:g}")
        print(", ".join(ACTIONS[action] for action in plan.actions))
    return 1 if plan is None else 0


def empowerment(args: Args) -> int:
    from habilis.empowerment.tables import save_table, state_table

    mdp = habilis.tabulate(load_world(args.world, args.tool))
    bits = habilis.empowerment(mdp, args.horizon, args.sensor, _actions(args.actions))
    if args.out is not None:
        _save(args.out, lambda path: save_table(state_table(mdp, bits), path))
    summary = {
        "states": len(bits),
        "mean": float(bits.mean()),
        "min": float(bits.min()),
        "max": float(bits.max()),
    }
    if mdp.flags["equipped"].any():
        summary["mean_equipped"] = float(bits[mdp.flags["equipped"]].mean())
    if args.json:
        return _print_json(summary | {"out": args.out and str(args.out)})
    print(f"{args.horizon}-step empowerment through the sensor {args.sensor!r}, in bits")
    for name, value in summary.items():
        print(f"{name:>14}  {value:,}" if name == "states" else f"{name:>14}  {value:.4f}")
    if args.out is not None:
        print(f"values of all states: {args.out}")
    return 0


def landscape(args: Args) -> int:
    from habilis.empowerment.measures import landscape as measure
    from habilis.worlds.pictures import landscape_figure, save_figure

    world = load_world(args.world, args.tool)
    if args.tool_at is not None and world.tool == NO_TOOL:
        raise ValueError(f"{world.name} has no tool here; leave out --tool-at, or give --tool")
    mdp = habilis.tabulate(world)
    tool, thing = args.tool_at or world.tool_cell, args.object_at or world.object
    values = measure(
        mdp, args.horizon, args.sensor, _actions(args.actions), tool=tool, object=thing
    )
    if args.out is not None:
        from dataclasses import replace

        shown = replace(world, tool_cell=tool, object=thing)
        title = f"{args.horizon}-step empowerment, sensor {args.sensor!r}"
        figure = landscape_figure(shown, {title: values})
        _save(args.out, lambda path: save_figure(figure, path))
    if args.json:
        rows = [[None if np.isnan(v) else v for v in row] for row in values.tolist()]
        return _print_json({"values": rows})
    for row in values:
        print(" ".join("    ." if np.isnan(value) else f"{value:5.2f}" for value in row))
    if args.out is not None:
        print(f"picture: {args.out}")
    return 0


def compare(args: Args) -> int:
    from habilis.empowerment.measures import compare as measure
    from habilis.empowerment.measures import ranking

    averages = measure(load_world(args.world), args.tools, args.horizon)
    if args.json:
        return _print_json({"averages": averages, "horizon": args.horizon})
    print(f"average {args.horizon}-step object empowerment, in bits")
    bare = averages.get(NO_TOOL)
    for tool in ranking(averages):
        verdict = ""
        if bare is not None and tool != NO_TOOL:
            verdict = "useful" if averages[tool] > bare else "encumbers the agent"
        print(f"{tool:>10}  {averages[tool]:.4f}  {verdict}".rstrip())
    return 0


def train(args: Args) -> int:
    from habilis.learning.arguments import config_from_args

    learning = import_from("habilis.learning.train", "learn")
    folder = import_from("habilis.learning.folder", "learn")
    display = import_from("habilis.learning.display", "learn")
    config = config_from_args(args)
    folder.check_unused(args.out)
    with display.progress_bars([args.world]) as show:
        run = learning.train(config, show)
    folder.save_run(run, args.out)
    finished = [at for at in run.converged_at if at is not None]
    summary = {
        "best_return": run.best_return,
        "converged": len(finished),
        "runs": config.runs,
        "converged_at": list(run.converged_at),
        "mean_episodes": float(np.mean(finished)) if finished else None,
        "out": str(args.out),
    }
    if args.json:
        return _print_json(summary)
    mean = f", after {summary['mean_episodes']:,.0f} episodes on average" if finished else ""
    print(f"{len(finished)} of {config.runs} runs converged{mean}; see {args.out}")
    return 0


def watch(args: Args) -> int:
    from habilis.worlds.pictures import colored_text, save_gif
    from habilis.worlds.table import placement

    folder = import_from("habilis.learning.folder", "learn")
    replay = import_from("habilis.learning.replay", "learn")
    run = folder.load_run(args.folder)
    episode = replay.play(run, args.run)
    mdp = habilis.tabulate(run.world)
    frames = [placement(run.world, mdp, state) for state in episode.states]
    if args.gif is not None:
        _save(args.gif, lambda path: save_gif(frames, path))
    if args.json:
        _print_json(
            {"steps": len(episode.actions), "return": episode.episode_return}
            | {"finished": episode.finished, "actions": list(episode.actions)}
        )
    else:
        console = _console()
        if console.is_terminal:
            _animate(console, [colored_text(frame) for frame in frames], 1 / args.speed)
        else:
            console.print(colored_text(frames[-1]))
        print(", ".join(ACTIONS[action] for action in episode.actions))
        end = "the goal is reached" if episode.finished else "the policy goes round in circles"
        print(f"{end}: {len(episode.actions)} steps, return {episode.episode_return:g}")
    return 0 if episode.finished else 1


def reproduce(args: Args) -> int:
    study = import_from("habilis.studies.reproduce", "learn")
    result = study.reproduce(args.out, quick=args.quick, show_progress=True)
    if args.json:
        return _print_json(result.summary())
    print(result.text())
    return 0


def bench(args: Args) -> int:
    from habilis.benchmarks import run_benchmarks

    results = run_benchmarks(args.what)
    if args.json:
        return _print_json({"results": [result.as_dict() for result in results]})
    for result in results:
        print(result)
    return 0


class _Parser(argparse.ArgumentParser):
    """Refuses bad usage in one line, as every other bad input is."""

    def error(self, message: str) -> NoReturn:
        raise ValueError(f"{message}; see {self.prog} --help")


def _parser() -> argparse.ArgumentParser:
    parser = _Parser(prog="habilis", description=_ABOUT)
    parser.add_argument("--version", action="version", version=habilis.__version__)
    verbs = parser.add_subparsers(required=True, metavar="VERB", parser_class=_Parser)

    def verb(function: Callable[[Args], int], text: str, example: str) -> argparse.ArgumentParser:
        added = verbs.add_parser(
            function.__name__,
            help=text,
            description=text[0].upper() + text[1:] + ".",
            epilog=f"example: {example}",
        )
        added.set_defaults(verb=function)
        added.add_argument("--json", action="store_true", help="print JSON, for machines")
        return added

    v = verb(worlds, "list the built-in worlds, or draw one", "habilis worlds yard --tool broom")
    v.add_argument("name", nargs="?", metavar="NAME", help="a built-in world or a map file")
    _tool(v)
    v.add_argument("--out", type=Path, metavar="F.png", help="picture (.png, .svg, .pdf)")

    v = verb(solve, "find a shortest plan", "habilis solve corridor --tool none")
    _world(v)

    v = verb(
        empowerment,
        "compute the empowerment of every state",
        "habilis empowerment corridor --sensor object --horizon 6 --out bits.csv",
    )
    _world(v)
    _measure(v)
    v.add_argument("--out", type=Path, metavar="F.csv", help="all values (.csv or .parquet)")

    v = verb(
        landscape,
        "empowerment for every agent cell, tool and can where the map has them",
        "habilis landscape corridor --sensor object --horizon 6 --out landscape.png",
    )
    _world(v)
    _measure(v)
    v.add_argument("--tool-at", type=_cell, metavar="ROW,COLUMN", help="another cell for the tool")
    v.add_argument("--object-at", type=_cell, metavar="ROW,COLUMN", help="another for the can")
    v.add_argument("--out", type=Path, metavar="F.png", help="picture (.png, .svg, .pdf)")

    v = verb(
        compare,
        "average object empowerment with each tool, and without",
        "habilis compare yard --tools picker,broom,none --horizon 3",
    )
    v.add_argument("world", metavar="WORLD", help="a built-in world or a map file")
    v.add_argument("--tools", type=_words, default=["picker", "broom", NO_TOOL], metavar="A,B,...")
    v.add_argument("--horizon", type=int, required=True, help="number of actions")

    v = verb(
        train,
        "train agents, with empowerment in the reward or without",
        "habilis train corridor --intrinsic object --horizon 6 --beta 0.07 --out runs/toe",
    )
    _world(v)
    from habilis.learning.arguments import add_config_arguments

    add_config_arguments(v)
    v.add_argument("--out", type=Path, required=True, metavar="DIR", help="a new folder")

    v = verb(watch, "replay what an agent learned", "habilis watch runs/toe --gif toe.gif")
    v.add_argument("folder", type=Path, metavar="DIR", help="folder of a run")
    v.add_argument("--run", type=int, default=0, help="which of its runs (default 0)")
    v.add_argument("--gif", type=Path, metavar="F.gif", help="write the episode as a GIF")
    v.add_argument("--speed", type=_positive, default=4.0, help="steps a second (default 4)")

    v = verb(
        reproduce,
        "recompute the paper: every table, figure and number",
        "habilis reproduce --out paper",
    )
    v.add_argument("--out", type=Path, required=True, metavar="DIR", help="a new folder")
    v.add_argument("--quick", action="store_true", help="few runs and episodes, in 3 minutes")

    v = verb(bench, "measure our speed beside the alternatives", "habilis bench empowerment")
    v.add_argument("what", nargs="*", metavar="WHAT", help="which benchmarks (default all)")
    return parser


def _world(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("world", metavar="WORLD", help="a built-in world or a map file")
    _tool(parser)


def _tool(parser: argparse.ArgumentParser) -> None:
    text = "picker, broom or none, in the place of the map's own"
    parser.add_argument("--tool", metavar="TOOL", help=text)


def _measure(parser: argparse.ArgumentParser) -> None:
    sensor = "state, agent, tool or object (default state)"
    parser.add_argument("--sensor", default="state", help=sensor)
    parser.add_argument("--horizon", type=int, required=True, help="number of actions")
    parser.add_argument("--actions", default="all", help="all, moves, tool, or indices as 0,1,2")


def _actions(text: str) -> list[int] | None:
    named = {"all": None, "moves": [0, 1, 2, 3], "tool": [4, 5, 6, 7]}
    if text in named:
        return named[text]
    try:
        return [int(part) for part in text.split(",")]
    except ValueError:
        raise ValueError(
            f"actions {text!r} are unknown; use all, moves, tool, or indices as 0,1,2"
        ) from None


def _cell(text: str) -> Cell:
    try:
        row, column = (int(part) for part in text.split(","))
    except ValueError:
        raise argparse.ArgumentTypeError(f"{text!r} is no cell, as 2,6 for row,column") from None
    return row, column


def _words(text: str) -> list[str]:
    return [word for word in text.split(",") if word]


def _positive(text: str) -> float:
    value = float(text)
    if not 0 < value < float("inf"):
        raise argparse.ArgumentTypeError(f"{text} is not above 0")
    return value


def _print_json(value: Any) -> int:
    print(json.dumps(value))
    return 0


def _save(path: Path, write: Callable[[Path], Any]) -> None:
    try:
        write(path)
    except OSError as error:
        raise ValueError(f"{path}: cannot be written ({error.strerror or error})") from error


def _console():
    from rich.console import Console

    return Console(highlight=False)


def _animate(console, frames: list, seconds: float) -> None:
    import time

    from rich.live import Live

    with Live(frames[0], console=console, auto_refresh=False) as live:
        for frame in frames:
            live.update(frame, refresh=True)
            time.sleep(seconds)


if __name__ == "__main__":
    sys.exit(main())
