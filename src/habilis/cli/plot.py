"""`habilis plot`: learning curves."""

import argparse
from pathlib import Path

from habilis.cli.arguments import Args
from habilis.cli.output import print_json, print_written, save, shows_progress
from habilis.extras import import_from
from habilis.files import PICTURES, check_file
from habilis.progress import progress_bar

HELP: str = "draw learning curves with intervals, of one or several runs"
EXAMPLE: str = "habilis plot runs/none runs/toe --out curves.svg"
COMMON: tuple[str, ...] = ("--out", "--value", "--x")


def add_arguments(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("folders", type=Path, nargs="+", metavar="DIR", help="folders of runs")
    parser.add_argument(
        "--out",
        type=Path,
        metavar="F.png",
        help="picture (.png, .svg, .pdf; default curves.png, or none with --json)",
    )
    parser.set_defaults(writes={"out": PICTURES})
    parser.add_argument(
        "--x", choices=("episodes", "steps"), default="episodes", help="horizontal axis"
    )
    parser.add_argument(
        "--value",
        choices=("return", "length", "equipped", "attached"),
        default="return",
        help="per episode: extrinsic return (default), number of steps, share of steps with the "
        "tool in hand, or share of those with the object attached",
    )
    parser.add_argument(
        "--statistic",
        choices=("mean", "iqm"),
        default="mean",
        help="over the runs: mean (default) or interquartile mean",
    )


def run(args: Args) -> int:
    folder = import_from("habilis.learning.folder", "learn")
    curves = import_from("habilis.learning.curves", "learn")
    picture = import_from("habilis.learning.curves_picture", "learn")
    from habilis.worlds.pictures.figures import save_figure

    for place in args.folders:
        if args.folders.count(place) > 1:
            raise ValueError(f"{place}: is named twice; name each folder once")
    out = args.out
    if out is None and not args.json:
        out = picture.DEFAULT
        check_file(out, PICTURES)
    runs = [folder.load_latest(place) for place in args.folders]
    labels = picture.labels([run.config for run in runs], [str(place) for place in args.folders])
    drawn = {
        label: curves.learning_curve(run, args.value, args.x, args.statistic)
        for label, run in zip(labels, runs, strict=True)
    }
    if out is not None:
        best = [run.best_return for run in runs] if args.value == "return" else []
        with progress_bar("drawing", shows_progress(args)):
            figure = picture.curves_figure(drawn, best)
            save(out, lambda path: save_figure(figure, path))
    if args.json:
        described = [
            {"folder": str(place), "label": label} | curve.as_dict()
            for place, (label, curve) in zip(args.folders, drawn.items(), strict=True)
        ]
        return print_json(
            {"x": args.x, "value": args.value, "statistic": args.statistic, "curves": described}
            | {"out": out and str(out)}
        )
    for label, curve in drawn.items():
        print(f"{label}: {curve.text()}")
    if out is not None:
        print_written(out)
    return 0
