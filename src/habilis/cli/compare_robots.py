"""`habilis compare` of a MuJoCo file: the tools of a hand that pushes a puck."""

from typing import TYPE_CHECKING

import numpy as np

from habilis.cli.arguments import Args
from habilis.cli.executors import OPTIONS
from habilis.cli.output import print_json, print_written, save, shows_progress
from habilis.files import PICTURES
from habilis.reprs import counted

if TYPE_CHECKING:
    from habilis.robots.comparison import ToolComparison

SUFFIX = ".xml"
_HORIZON, _SIDE, _SEEDS = 8, 8, 4
_FOR_WORLDS = ("target", "max_states", "pairs", "slip", *OPTIONS)


def run_robots(args: Args) -> int:
    """Prints a line for each tool, and writes pictures and tables."""
    from habilis.estimators.counting import Counting
    from habilis.robots.comparison import SEQUENCES, compare_tools
    from habilis.robots.landscapes import draw_comparison
    from habilis.robots.pushing import PushingSimulator
    from habilis.worlds.pictures.figures import save_figure

    for name in _FOR_WORLDS:
        if getattr(args, name):
            raise ValueError(f"{args.flags[name]} is for worlds and puzzles; leave it out")
    if args.unit != "bits" or args.method != "exact":
        raise ValueError("the tools of a robot are counted, in bits; leave out --unit and --method")
    tool = "none" if not args.tools else args.tools[0]
    resolution = PushingSimulator(args.world, tool).resolution
    found = compare_tools(
        args.world,
        args.tools,
        _HORIZON if args.horizon is None else args.horizon,
        method=Counting(resolution, SEQUENCES if args.sequences is None else args.sequences),
        side=_SIDE if args.side is None else args.side,
        seeds=_SEEDS if args.seeds is None else args.seeds,
        seed=args.seed,
        show_progress=shows_progress(args),
    )
    frame = found.frame()
    for path in args.out:
        if path.suffix in PICTURES:
            save(path, lambda path: save_figure(draw_comparison(found, args.world), path))
        elif path.suffix == ".csv":
            save(path, frame.write_csv)
        else:
            save(path, frame.write_parquet)
    if args.json:
        rows = [
            {name: None if value == np.inf else value for name, value in row.items()}
            for row in frame.to_dicts()
        ]
        return print_json(
            {
                "horizon": found.horizon,
                "placements": found.bits.shape[1],
                "seeds": found.bits.shape[2],
                "kind": found.kind,
                "tools": rows,
            }
        )
    _print(found)
    for path in args.out:
        print_written(path)
    return 0


def check(args: Args) -> None:
    """Refuses options of robots for anything else, and files that a table of tools is not for."""
    robot = args.world.endswith(SUFFIX)
    for name in ("side", "seeds", "sequences"):
        if not robot and getattr(args, name) is not None:
            raise ValueError(
                f"{args.flags[name]} is for MuJoCo files ({SUFFIX}) of a hand and a puck; leave it "
                "out"
            )
    for path in args.out:
        if robot and path.suffix not in (*PICTURES, ".csv", ".parquet"):
            raise ValueError(
                f"{path}: the tools of a robot are drawn or a table; end it with "
                f"{', '.join(PICTURES)}, .csv or .parquet"
            )


def _print(found: "ToolComparison") -> None:
    count, seeds = found.bits.shape[1:]
    searches = counted(seeds, "search", "searches")
    print(
        f"average {found.horizon}-step object empowerment of the puck over {count} placements, "
        f"lower bounds in bits ({searches} each)"
    )
    heads = ["", "bits", "95 %", "rank", "influence", "range", "latency", "better", "worse"]
    rows = [heads]
    for row in found.frame().iter_rows(named=True):
        ranks = row["rank_best"], row["rank_worst"]
        rows.append(
            [
                row["tool"],
                f"{row['bits']:.3f}",
                f"{row['bits_low']:.3f} to {row['bits_high']:.3f}",
                f"{ranks[0]}" if ranks[0] == ranks[1] else f"{ranks[0]}-{ranks[1]}",
                f"{row['influenced']:.0%}",
                f"{row['range']:.2f}",
                f"{row['latency']:g}",
                *("-" if row[name] is None else f"{row[name]:.0%}" for name in ("better", "worse")),
            ]
        )
    widths = [max(map(len, column)) for column in zip(*rows, strict=True)]
    for row in rows:
        print("  ".join(f"{cell:>{width}}" for cell, width in zip(row, widths, strict=True)))
    print("influence: placements with any; range: of those the farthest from the hand;")
    print("latency: fewest actions with influence; better, worse: placements in which every search")
    print("with the tool finds more, or fewer, outcomes than every search with none")
