"""`habilis worlds`: the built-in worlds."""

import argparse
from pathlib import Path

from habilis.cli.arguments import Args, add_tool
from habilis.cli.output import console, print_json, print_written, save, shows_progress
from habilis.cli.puzzles import puzzle_of
from habilis.files import PICTURES
from habilis.progress import progress_bar
from habilis.worlds.world import World, load_world, world_names

HELP: str = "list the built-in worlds, or draw one"
EXAMPLE: str = "habilis worlds yard --tool broom"
COMMON: tuple[str, ...] = ("--tool", "--out")


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument(
        "name", nargs="?", metavar="NAME", help="a built-in world, or the file of a map or a puzzle"
    )
    add_tool(parser)
    parser.add_argument("--out", type=Path, metavar="F.png", help="picture (.png, .svg, .pdf)")
    parser.set_defaults(writes={"out": PICTURES})


def run(args: Args) -> int:
    if args.name is None:
        if args.tool is not None or args.out is not None:
            raise ValueError("no world to draw; give its name with --tool or --out")
        listed = [load_world(name) for name in world_names()]
        if args.json:
            return print_json({"worlds": [world.name for world in listed]})
        for world in listed:
            print(f"{world.name}: {world.height} x {world.width} cells, tool {world.tool}")
        return 0
    puzzle = puzzle_of(args, args.name)
    world = load_world(args.name, args.tool) if puzzle is None else puzzle
    if args.out is not None:
        from habilis.worlds.pictures.figures import save_picture

        with progress_bar("drawing", shows_progress(args)):
            save(args.out, lambda path: save_picture(world, path))
    if puzzle is not None and args.json:
        fields = {"name": puzzle.name, "height": puzzle.height, "width": puzzle.width}
        fields |= {"objects": list(puzzle.objects), "goals": len(puzzle.goals)}
        return print_json(fields | {"map": puzzle.colored_text().plain.split("\n")})
    if isinstance(world, World) and args.json:
        fields = {"name": world.name, "height": world.height, "width": world.width}
        fields |= {"tool": world.tool, "map": list(world.rows)}
        if world.header:
            fields |= {"header": world.header}
        if not world.single:
            fields |= {"tools": [tool.name for tool in world.tools]}
            fields |= {"objects": [thing.name for thing in world.objects]}
        return print_json(fields)
    from habilis.worlds.pictures.figures import colored_text

    if isinstance(world, World):
        for line in world.header:
            print(line)
    console().print(colored_text(world), soft_wrap=puzzle is not None)
    if args.out is not None:
        print_written(args.out)
    return 0
