"""`habilis futures`: the action sequences worth choosing among."""

import argparse
from pathlib import Path

import habilis
from habilis.bridges.puzzles.pushworld import PushWorld
from habilis.cli.arguments import (
    Args,
    action_indices,
    add_limits,
    add_measure,
    add_most,
    add_places,
    add_tolerance,
    add_unit,
    add_world,
    cells_of,
    max_states,
    measure_options,
    parse_cell,
)
from habilis.cli.output import print_json, print_written, save, shows_progress
from habilis.cli.puzzles import placed, puzzle_of
from habilis.empowerment.sensors import factor_of
from habilis.files import PICTURES
from habilis.progress import progress_bar
from habilis.worlds.placements import start_of
from habilis.worlds.reach import reachable
from habilis.worlds.world import World, load_world

HELP: str = "the distinguishable action sequences, from the map's start"
EXAMPLE: str = "habilis futures yard --sensor object --horizon 3 --agent-at 8,5 --tool-at 8,4"
COMMON: tuple[str, ...] = ("--horizon", "--sensor", "--out")


def add_arguments(parser: argparse.ArgumentParser) -> None:
    add_world(parser)
    add_measure(parser)
    add_unit(parser)
    add_tolerance(parser)
    add_limits(parser)
    add_most(parser)
    parser.set_defaults(lacks=("method", "samples", "seed", "threads"))
    text = "cell of the agent (default: that of the map)"
    parser.add_argument("--agent-at", type=parse_cell, metavar="ROW,COLUMN", help=text)
    add_places(parser)
    parser.add_argument("--out", type=Path, metavar="F.png", help="picture (.png, .svg, .pdf)")
    parser.set_defaults(writes={"out": PICTURES})


def run(args: Args) -> int:
    from habilis.analysis.futures import arrows_legend, futures_figure, sequence_text
    from habilis.analysis.futures import futures as measure

    world, mdp = _around(args)
    cells = [name for name in mdp.factors if mdp.is_cell(name)]
    if args.out and factor_of(mdp, args.sensor) not in cells:
        raise ValueError(
            f"a picture needs cells; use --sensor {', '.join(cells)}, or leave out --out"
        )
    found = measure(
        mdp,
        mdp.start,
        args.horizon,
        args.sensor,
        action_indices(args.actions),
        **measure_options(args),
    )
    if args.out is not None:
        from habilis.worlds.pictures.figures import save_figure

        with progress_bar("drawing", shows_progress(args)):
            figure = futures_figure(world, mdp, found, args.sensor)
            save(args.out, lambda path: save_figure(figure, path))
    if args.json:
        return print_json(
            {
                "empowerment": found.empowerment,
                "gap": found.gap,
                "unit": found.unit,
                "sequences": found.sequences.tolist(),
                "probability": found.probability.tolist(),
                "observations": found.observations.tolist(),
                "seen": found.seen.tolist(),
            }
        )
    count = len(found.observations)
    possible = f"{count} possible observation{'s' if count > 1 else ''}"
    print(f"{found.empowerment:.4f} {found.unit}, {possible}")
    if legend := arrows_legend(mdp):
        print(legend)
    shown = list(zip(found.probability, found.sequences, strict=True))
    for probability, sequence in shown[:20]:
        print(f"{probability:8.2%}  {sequence_text(mdp, sequence)}")
    if len(shown) > 20:
        print(f"          and {len(shown) - 20} more sequences")
    if args.out is not None:
        print_written(args.out)
    return 0


def _around(args: Args) -> tuple[World | PushWorld, habilis.TabularMDP]:
    """A world or a puzzle with everything in its place, and a table that has its futures."""
    steps, most, show = max(args.horizon, 0), max_states(args), shows_progress(args)
    puzzle = puzzle_of(args, args.world, ("tool", "tool_at"))
    if puzzle is not None:
        puzzle = placed(puzzle, args.agent_at, args.object_at)
        mdp = habilis.explore(puzzle, None, steps, most, show_progress=show)
        return puzzle, mdp.slippery(args.slip)
    world = load_world(args.world, args.tool)
    world = world.with_cells(
        agent=args.agent_at,
        tool=cells_of(world, "tool", args.tool_at),
        object=cells_of(world, "object", args.object_at),
    )
    if not world.single:
        return world, reachable(world, start_of(world), steps, most, show)[0].slippery(args.slip)
    return world, habilis.tabulate(world, args.slip, max_states=most, show_progress=show)
