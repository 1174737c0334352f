"""The verbs of the command line that train agents and show what they learned."""

import shlex
from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from habilis.cli_arguments import Args
from habilis.cli_output import console, print_json, refuse, save, shows_progress
from habilis.extras import import_from
from habilis.files import PICTURES, check_file
from habilis.progress import progress_bar

if TYPE_CHECKING:
    from rich.console import Console
    from rich.text import Text


def train(args: Args) -> int:
    from habilis.learning.arguments import config_from_args

    learning = import_from("habilis.learning.train", "learn")
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
        return refuse(f"stopped; {kept}go on with: {command}", status=128 + number)
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
    print(f"{len(finished)} of {config.runs} runs converged{mean}; see {args.out}")
    return 0


def watch(args: Args) -> int:
    from habilis.worlds.pictures.figures import colored_text
    from habilis.worlds.pictures.video import check_video, save_gif, save_mp4
    from habilis.worlds.table import placement

    if args.mp4:
        check_video()
    folder = import_from("habilis.learning.folder", "learn")
    replay = import_from("habilis.learning.replay", "learn")
    ended = folder.is_finished(args.folder)
    run = folder.load_latest(args.folder)
    episode = replay.play(run, args.run, seed=args.seed)
    mdp = replay.table_of(run)
    by_chance = mdp.is_stochastic
    shares = replay.success(run, args.run) if run.config.starts or by_chance else None
    frames = [placement(run.world, mdp, state) for state in episode.states]
    films = [(path, write) for path, write in ((args.mp4, save_mp4), (args.gif, save_gif)) if path]
    for path, write in films:
        with progress_bar("drawing", shows_progress(args)):
            save(path, partial(write, frames))
    trained = int((run.episodes["run"] == args.run).sum())
    if args.json:
        print_json(
            {"steps": len(episode.actions), "return": episode.episode_return}
            | {"finished": episode.finished, "actions": list(episode.actions)}
            | {"run": args.run, "episodes": trained, "ended": ended}
            | ({} if shares is None else {"success": shares._asdict()})
        )
        return 0 if episode.finished else 1
    screen = console()
    if screen.is_terminal:
        _animate(screen, [colored_text(frame) for frame in frames], 1 / args.speed)
    else:
        screen.print(colored_text(frames[-1]))
    print(", ".join(mdp.actions[action] for action in episode.actions))
    failed = "the goal is not reached" if by_chance else "the policy goes round in circles"
    end = "the goal is reached" if episode.finished else failed
    print(f"{end}: {len(episode.actions)} steps, return {episode.episode_return:g}")
    so_far = "" if ended else ", as the last checkpoint has it: training has not ended"
    print(f"run {args.run} after {trained:,} episodes{so_far}")
    if shares is not None:
        unseen = "" if shares.unseen is None else f", {shares.unseen:.0%} of those held out"
        several = bool(run.config.starts)
        word, whole = ("from", "the starts trained from") if several else ("in", "all episodes")
        print(f"reaches the goal {word} {shares.seen:.0%} of {whole}{unseen}")
    for path, _ in films:
        print(f"film: {path}")
    return 0 if episode.finished else 1


def plot(args: Args) -> int:
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
        told = [
            {"folder": str(place), "label": label} | curve.as_dict()
            for place, (label, curve) in zip(args.folders, drawn.items(), strict=True)
        ]
        return print_json(
            {"x": args.x, "value": args.value, "statistic": args.statistic, "curves": told}
            | {"out": out and str(out)}
        )
    for label, curve in drawn.items():
        print(f"{label}: {curve.text()}")
    print(f"picture: {out}")
    return 0


def _animate(screen: "Console", frames: "list[Text]", seconds: float) -> None:
    import time

    from rich.live import Live

    with Live(frames[0], console=screen, auto_refresh=False) as live:
        for frame in frames:
            live.update(frame, refresh=True)
            time.sleep(seconds)


def sweep(args: Args) -> int:
    command = import_from("habilis.sweeps.command", "learn")
    try:
        result = command.run(args)
    except KeyboardInterrupt as stop:
        return refuse(str(stop) or "interrupted", status=128 + getattr(stop, "signal", 2))
    if args.json:
        return print_json(result)
    command.show(result)
    return 0


def study(args: Args) -> int:
    studies = import_from("habilis.studies.learners", "learn")
    show = import_from("habilis.sweeps.command", "learn")
    try:
        with show.progress_bar() as on_progress:
            answers = studies.run_studies(
                args.names, args.out, args.quick, args.resume, on_progress
            )
    except KeyboardInterrupt as stop:
        return refuse(str(stop) or "interrupted", status=128 + getattr(stop, "signal", 2))
    if args.json:
        told = {answer.study.name: answer.as_dict() for answer in answers}
        return print_json({"studies": told, "out": str(args.out)})
    for answer in answers:
        print(f"{answer.study.title} ({answer.study.name})")
        for line in answer.outcome:
            print(f"  {line}")
    print(f"report: {args.out / studies.PAGE}")
    return 0
