"""`habilis train`: agents with empowerment in the reward, or without."""

import argparse
import shlex
from pathlib import Path

import numpy as np

from habilis.cli.arguments import Args, add_world
from habilis.cli.output import print_json, print_written, refuse
from habilis.extras import import_from
from habilis.files import FOLDER

HELP: str = "train agents, with empowerment in the reward or without"
EXAMPLE: str = "habilis train corridor --intrinsic object --horizon 6 --beta 0.07 --out runs/toe"
COMMON: tuple[str, ...] = ("--out", "--intrinsic", "--horizon", "--beta")


def add_arguments(parser: argparse.ArgumentParser) -> None:
    add_world(parser, or_environment=True)
    from habilis.learning.arguments import add_config_arguments

    add_config_arguments(parser)
    parser.add_argument("--out", type=Path, required=True, metavar="DIR", help="a new folder")
    parser.add_argument(
        "--resume", action="store_true", help="continue the interrupted run in --out DIR"
    )
    seconds = "time between checkpoints (default 10)"
    parser.add_argument("--checkpoint-seconds", type=float, default=10.0, metavar="S", help=seconds)
    lanes = (
        "runs in one compiled batch; changing it changes rounding, and so the runs (default 5 on a "
        "CPU; on a GPU all pending runs, at most 512)"
    )
    parser.add_argument("--lanes", type=int, metavar="N", help=lanes)
    parser.set_defaults(writes={"out": FOLDER})


def run(args: Args) -> int:
    from habilis.learning.arguments import config_from_args

    learning = import_from("habilis.learning.runner", "learn")
    display = import_from("habilis.learning.display", "learn")
    config = config_from_args(args)
    try:
        with display.progress_bars([args.world]) as show:
            run = learning.train(
                config,
                show,
                out=args.out,
                resume=args.resume,
                checkpoint_seconds=args.checkpoint_seconds,
                lanes=args.lanes,
            )
    except KeyboardInterrupt as stop:
        command = shlex.join(["habilis", *args.command] + ["--resume"] * (not args.resume))
        number = getattr(stop, "signal", 2)
        kept = f"all is kept in {args.out}; " if str(stop) else ""
        return refuse(f"stopped; {kept}continue with: {command}", status=128 + number)
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
        return print_json(summary)
    mean = f", after {summary['mean_episodes']:,.0f} episodes on average" if finished else ""
    print(f"{len(finished)} of {config.runs} runs converged{mean}")
    print_written(args.out)
    if not finished:
        print(
            f"no run came close enough to the best return, {run.best_return:g}: raise --episodes, "
            f"or look at what they do with: habilis watch {shlex.quote(str(args.out))}"
        )
    return 0
