"""The verb `habilis reconstruct`."""

import json
import sys
import time
from argparse import Namespace
from dataclasses import replace
from pathlib import Path

from habilis.files import check_folder, save_whole, writing
from habilis.studies.paper.findings import Number
from habilis.studies.paper.numbers import number_in
from habilis.studies.paper.targets import TargetMap, load_targets
from habilis.studies.paper.worlds import OVER, CachedWorld
from habilis.studies.reconstruction.annealing import Schedule
from habilis.studies.reconstruction.search import Report, attempts
from habilis.worlds.map_text import COMMENT
from habilis.worlds.tools import Reading
from habilis.worlds.world import World, load_world, world_names


def reconstruct(args: Namespace) -> int:
    """Searches, shows each map beside what is stated, and writes it if asked to.

    Returns:
        The exit status: 0 if there are as many maps as asked for, 1 if not.
    """
    targets = _read_so(load_targets(args.stated), args)
    for name in ("count", "attempts", "changes", "attempt"):
        if getattr(args, name) < 1:
            raise ValueError(f"--{name} is {getattr(args, name)}; give 1 or more")
    if not args.hot > Schedule.cold:
        raise ValueError(f"--hot is {args.hot:g}; give more than {Schedule.cold:g}")
    built_in = (name for name in world_names() if f"{name}-".startswith(f"{targets.name}-"))
    earlier = {} if args.after is None else _maps_in(args.after, targets)
    known = [*map(load_world, built_in), *earlier.values()]
    first = max(earlier, default=0) + 1
    begin = None if args.begin is None else _beginning(targets, args.begin)
    schedule = Schedule(args.changes, args.hot)
    if args.out is not None:
        _make_room(args.out, targets, range(first, first + args.count))
    maps: list[dict] = []
    nearest, report, began = None, _reporter(), time.perf_counter()
    for attempt in attempts(targets, args.seed, known, begin, schedule, report, args.attempt):
        if nearest is None or attempt.best.energy < nearest.energy:
            nearest = attempt.best
        if attempt.found:
            world = replace(attempt.best.world, name=_name(targets, first + len(maps)))
            numbers = [
                number_in(CachedWorld(world, targets.over), number) for number in targets.numbers
            ]
            maps.append(
                {
                    "name": world.name,
                    "map": world.text().splitlines(),
                    "attempt": attempt.number,
                    "seconds": round(time.perf_counter() - began, 1),
                    "numbers": {number.text: number.ours for number in numbers},
                }
            )
            if args.out is not None:
                _write(args, world, targets, attempt.number)
            if not args.json:
                _print(world, numbers)
                if args.out is not None:
                    print(f"written to {_path(args.out, targets, first + len(maps) - 1)}")
            began = time.perf_counter()
        if len(maps) == args.count or attempt.number >= args.attempt + args.attempts - 1:
            break
    report("")
    if args.json:
        print(json.dumps({"stated": targets.source, "seed": args.seed, "maps": maps}))
    if len(maps) == args.count:
        return 0
    assert nearest is not None, "there was an attempt"
    missed = [s.text for s, part in zip(targets.numbers, nearest.parts, strict=True) if part]
    print(
        f"habilis: {len(maps)} of {args.count} maps found in {args.attempts} attempts"
        + (f"; the nearest other missed: {'; '.join(missed)}" if missed and not maps else "")
        + "; give more --attempts or --changes, or state less",
        file=sys.stderr,
    )
    return 1


def _read_so(targets: TargetMap, args: Namespace) -> TargetMap:
    """The list under the reading of the rules, and of averages, that is asked for."""
    unknown, reading = Reading.of(f" {args.reading or ''}".rstrip())
    if unknown.strip():
        raise ValueError(
            f"--reading is {args.reading!r}; give some of {Reading(*[True] * 4).words}, or nothing"
        )
    return replace(targets, reading=reading, over=args.over)


def _beginning(targets: TargetMap, name: str) -> World:
    """The map to begin with, if changes can make of it what is sought."""
    world = load_world(name)
    if (world.height, world.width, world.tool) != (targets.height, targets.width, targets.tool):
        raise ValueError(
            f"{world.name}: is {world.height} x {world.width} with tool {world.tool}, but "
            f"{targets.name} speaks of {targets.height} x {targets.width} with tool "
            f"{targets.tool}; begin with such a map, or at random"
        )
    return replace(world, name=targets.name)


def _maps_in(folder: Path, targets: TargetMap) -> dict[int, World]:
    """The maps of earlier searches in a folder, by their numbers."""
    if not folder.is_dir():
        raise ValueError(f"{folder}: no such folder; name one with maps of earlier searches")
    found = {}
    for path in sorted(folder.glob(f"{targets.name}-*.txt")):
        number = path.stem.removeprefix(f"{targets.name}-")
        if number.isdecimal():
            found[int(number)] = load_world(path)
    return found


def _make_room(folder: Path, targets: TargetMap, numbers: range) -> None:
    """Refuses a folder in which something would be overwritten, before anything is searched."""
    taken = [path for n in numbers if (path := _path(folder, targets, n)).exists()]
    if taken:
        raise ValueError(f"{taken[0]}: exists; name another folder, or remove it")
    check_folder(folder)


def _name(targets: TargetMap, number: int) -> str:
    return f"{targets.name}-{number:02}"


def _path(folder: Path, targets: TargetMap, number: int) -> Path:
    return folder / f"{_name(targets, number)}.txt"


def _write(args: Namespace, world: World, targets: TargetMap, attempt: int) -> None:
    lines = (
        f"Reconstructed, not the authors' map: attempt {attempt} of",
        f"habilis reconstruct {targets.source} --seed {args.seed} --changes {args.changes} "
        f"--hot {args.hot:g}"
        + (f" --from {args.begin}" if args.begin else "")
        + (f" --after {args.after}" if args.after else "")
        + (f' --reading "{targets.reading.words}"' if targets.reading.words else "")
        + (f" --over {targets.over}" if targets.over != OVER[0] else ""),
        f"Meets all {len(targets.numbers)} stated numbers of {targets.source}.toml.",
    )
    comments = "".join(f"{COMMENT} {line}\n" for line in lines)
    with writing(args.out):
        args.out.mkdir(parents=True, exist_ok=True)
    text = (comments + world.text()).encode()
    save_whole(args.out / f"{world.name}.txt", lambda file: file.write(text))


def _print(world: World, numbers: list[Number]) -> None:
    from rich.console import Console
    from rich.table import Table

    table = Table("number", title=f"{world.name}\n{world.text()}", title_justify="left", box=None)
    for name in ("stated", "found"):
        table.add_column(name, justify="right", no_wrap=True)
    for number in numbers:
        table.add_row(number.text, number.published, f"{number.ours:.4g} {number.unit}".strip())
    Console(highlight=False).print(table)


def _reporter() -> Report:
    """Writes progress to one line of a terminal, or a line every ten seconds elsewhere."""
    terminal, last = sys.stderr.isatty(), [time.perf_counter()]

    def report(line: str) -> None:
        now = time.perf_counter()
        if terminal:
            print(f"\r{line:<78}", end="" if line else "\r", file=sys.stderr, flush=True)
        elif line and now - last[0] > 10:
            print(line, file=sys.stderr, flush=True)
            last[0] = now

    return report
