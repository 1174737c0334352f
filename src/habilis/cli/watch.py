"""`habilis watch`: an episode of a trained agent."""

import argparse
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from habilis.cli.arguments import Args, parse_positive
from habilis.cli.output import console, print_json, print_written, save, shows_progress
from habilis.extras import import_from
from habilis.files import VIDEOS
from habilis.mdp import TabularMDP
from habilis.progress import progress_bar

if TYPE_CHECKING:
    from rich.console import Console
    from rich.text import Text

    from habilis.learning.runs import Run

HELP: str = "replay a trained agent"
EXAMPLE: str = "habilis watch runs/toe --run 2 --gif toe.gif"
COMMON: tuple[str, ...] = ("--run", "--gif", "--speed")
LISTED = 100
"""The number of actions that are printed; --json has all."""


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("folder", type=Path, metavar="DIR", help="folder of a run")
    parser.add_argument("--run", type=int, default=0, help="index of the run (default 0)")
    seed = "seed of random outcomes in a stochastic world (default 0)"
    parser.add_argument("--seed", type=int, default=0, help=seed)
    parser.add_argument("--gif", type=Path, metavar="F.gif", help="write the episode as a GIF")
    parser.add_argument("--mp4", type=Path, metavar="F.mp4", help="or as a video (extra [video])")
    parser.set_defaults(writes={"gif": VIDEOS[:1], "mp4": VIDEOS[1:]})
    parser.add_argument(
        "--speed", type=parse_positive, default=4.0, help="steps per second (default 4)"
    )


def run(args: Args) -> int:
    from habilis.worlds.pictures.figures import colored_text
    from habilis.worlds.pictures.video import check_video, save_gif, save_mp4
    from habilis.worlds.world import World

    if args.mp4:
        check_video()
    folder = import_from("habilis.learning.folder", "learn")
    replay = import_from("habilis.learning.replay", "learn")
    ended = folder.is_finished(args.folder)
    run = folder.load_latest(args.folder)
    episode = replay.play(run, args.run, seed=args.seed)
    mdp = replay.table_of(run)
    stochastic = mdp.is_stochastic
    on_map = isinstance(run.world, World)
    asked = on_map and (run.config.starts or stochastic)
    shares = replay.success(run, args.run) if asked else None
    expected = None if on_map else replay.expected_return(run, args.run)
    frames = _frames(args, run, mdp, episode.states)
    videos = [(path, write) for path, write in ((args.mp4, save_mp4), (args.gif, save_gif)) if path]
    for path, write in videos:
        with progress_bar("drawing", shows_progress(args)):
            save(path, partial(write, frames))
    trained = int((run.episodes["run"] == args.run).sum())
    if args.json:
        print_json(
            {"steps": len(episode.actions), "return": episode.episode_return}
            | {"finished": episode.finished, "actions": list(episode.actions)}
            | {"run": args.run, "episodes": trained, "ended": ended}
            | ({} if shares is None else {"success": shares._asdict()})
            | ({} if expected is None else {"expected": expected, "best": run.best_return})
        )
        return 0 if episode.finished else 1
    screen = console()
    if not frames:
        print(f"states {_listed(list(map(str, episode.states)))}")
    elif screen.is_terminal:
        _animate(screen, [colored_text(frame) for frame in frames], 1 / args.speed)
    else:
        screen.print(colored_text(frames[-1]))
    names = mdp.actions or tuple(map(str, range(mdp.action_count)))
    print(_listed([names[action] for action in episode.actions]))
    failed = "the goal is not reached" if stochastic else "the policy goes round in circles"
    end = "the goal is reached" if episode.finished else failed
    if not on_map:
        end = "the episode ends" if episode.finished else "the episode is truncated"
    print(f"{end}: {len(episode.actions)} steps, return {episode.episode_return:g}")
    so_far = "" if ended else ", as the last checkpoint has it: training has not ended"
    print(f"run {args.run} after {trained:,} episodes{so_far}")
    if expected is not None:
        print(f"the policy expects a return of {expected:.3f}, the best one {run.best_return:.3f}")
    if shares is not None:
        unseen = "" if shares.unseen is None else f", {shares.unseen:.0%} of those held out"
        several = bool(run.config.starts)
        word, whole = ("from", "the starts trained from") if several else ("in", "all episodes")
        print(f"reaches the goal {word} {shares.seen:.0%} of {whole}{unseen}")
    for path, _ in videos:
        print_written(path)
    return 0 if episode.finished else 1


def _listed(each: list[str]) -> str:
    """All, or of many the first: a policy that goes round in circles fills no screen."""
    more = len(each) - LISTED
    return ", ".join(each) if more <= 0 else f"{', '.join(each[:LISTED])}, and {more:,} more"


def _frames(args: Args, run: "Run", mdp: TabularMDP, states: tuple[int, ...]) -> list[Any]:
    """An episode's states as pictures show them; none of a table that has no pictures.

    Raises:
        ValueError: a video is asked for, and there are no pictures.
    """
    from habilis.worlds.table import placement
    from habilis.worlds.world import World

    if isinstance(run.world, World):
        return [placement(run.world, mdp, state) for state in states]
    sources = import_from("habilis.learning.sources", "learn")
    try:
        puzzle = sources.puzzle_of(run.config)
    except ValueError:
        if args.gif or args.mp4:
            raise
        puzzle = None
    if puzzle is not None:  # its factors are the cells of its bodies
        cells = np.stack([*mdp.factors.values()], axis=1)[[*states]].tolist()
        return [puzzle.at(tuple(row)) for row in cells]
    if args.gif or args.mp4:
        video = "--gif" if args.gif else "--mp4"
        raise ValueError(
            f"{args.folder}: was trained on a table, which has no pictures; leave out {video}"
        )
    return []


def _animate(screen: "Console", frames: "list[Text]", seconds: float) -> None:
    import time

    from rich.live import Live

    with Live(frames[0], console=screen, auto_refresh=False) as live:
        for frame in frames:
            live.update(frame, refresh=True)
            time.sleep(seconds)
