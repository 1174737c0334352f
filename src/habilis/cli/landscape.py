"""`habilis landscape`: empowerment for every agent cell."""

import argparse
from pathlib import Path

import numpy as np
from jaxtyping import Float64

from habilis.cli.arguments import (
    Args,
    action_indices,
    add_kind,
    add_measure,
    add_options,
    add_places,
    add_player,
    add_world,
    cells_of,
    horizon_of,
    measure_options,
)
from habilis.cli.executors import add_executor
from habilis.cli.output import print_json, print_written, save, shows_progress
from habilis.cli.puzzles import placed, puzzle_of
from habilis.files import PICTURES, TABLES
from habilis.progress import progress_bar
from habilis.worlds.world import load_world

HELP: str = "empowerment for every agent cell, everything else as on the map"
EXAMPLE: str = "habilis landscape corridor --sensor object --horizon 6 --out landscape.png"
COMMON: tuple[str, ...] = ("--horizon", "--sensor", "--out")


def add_arguments(parser: argparse.ArgumentParser) -> None:
    add_world(parser)
    add_measure(parser, needs_horizon=False)
    add_options(parser)
    add_places(parser)
    add_kind(parser)
    add_player(parser)
    kinds = "picture (.png, .svg, .pdf) or values (.csv, .parquet, .npz, .npy)"
    parser.add_argument("--out", type=Path, metavar="F.png", help=kinds)
    parser.set_defaults(writes={"out": (*PICTURES, *TABLES)})
    add_executor(parser)


def run(args: Args) -> int:
    from habilis.analysis.landscape import landscape as measure

    horizon = horizon_of(args)
    puzzle, where = puzzle_of(args, args.world, ("tool", "tool_at")), {}
    if puzzle is not None:
        world = placed(puzzle, None, args.object_at)
    else:
        world = load_world(args.world, args.tool)
        where["tool"] = cells_of(world, "tool", args.tool_at)
        where["object"] = cells_of(world, "object", args.object_at)
    found = measure(
        world,
        horizon,
        args.sensor,
        action_indices(args.actions),
        kind=args.kind,
        discount=args.discount,
        slack=args.slack,
        slip=args.slip,
        player=args.player,
        others=args.others,
        **where,
        **measure_options(args),
    )
    if args.out is not None:
        with progress_bar("drawing", shows_progress(args)):
            save(args.out, found.save)
    if args.json:
        gap = {} if found.gap is None else {"gap": _rows(found.gap)}
        return print_json({"values": _rows(found.values)} | gap | found.settings)
    for row in found.values:
        print(" ".join("    ." if np.isnan(value) else f"{value:5.2f}" for value in row))
    if args.out is not None:
        print_written(args.out)
    return 0


def _rows(values: Float64[np.ndarray, "rows columns"]) -> list[list[float | None]]:
    """Rows for JSON, null where there is no value."""
    return [[None if np.isnan(value) else value for value in row] for row in values.tolist()]
