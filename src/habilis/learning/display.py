"""Progress on the terminal."""

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager

from rich.console import Console
from rich.progress import BarColumn, TextColumn
from rich.progress import Progress as Bars

from habilis.learning.runs import Progress


@contextmanager
def progress_bars(labels: Sequence[str]) -> Iterator[Callable[[Progress], None]]:
    """Bars on standard error, one for each configuration, from the first report on.

    There are none where standard error is no terminal.

    Yields:
        What to hand to `train` as `on_progress`.
    """
    columns = (
        TextColumn("{task.description}"),
        BarColumn(bar_width=20),
        TextColumn("{task.fields[text]}"),
    )
    console = Console(stderr=True)
    bars = Bars(*columns, console=console, disable=not console.is_terminal)
    tasks = [bars.add_task(label, total=1.0, text="waiting") for label in labels]

    def show(progress: Progress) -> None:
        bars.start()
        bars.update(tasks[progress.config], completed=progress.share, text=_text(progress))

    try:
        yield show
    finally:
        if bars.live.is_started:
            bars.stop()


def _text(p: Progress) -> str:
    left = "done" if p.ended == p.runs else f"at most {_clock(p.seconds_left)} left"
    return (
        f"{p.episodes:,.0f} episodes, return {p.episode_return:.1f}, "
        f"{p.converged}/{p.runs} converged, {p.steps_per_second / 1e3:,.0f}k steps/s, {left}"
    )


def _clock(seconds: float) -> str:
    if seconds == float("inf"):
        return "?"
    minutes, seconds = divmod(round(seconds), 60)
    return f"{minutes}:{seconds:02}"
