"""Progress on the terminal."""

from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager

from rich.console import Console
from rich.progress import BarColumn, TextColumn
from rich.progress import Progress as Bars

from habilis.learning.runs import Progress

_BAR, _LABEL = 20, 24  # columns of a bar, and of what is beside it at most


@contextmanager
def progress_bars(labels: Sequence[str]) -> Iterator[Callable[[Progress], None]]:
    """Bars on standard error, one for each configuration, from the first report on.

    There are none where standard error is no terminal.

    Yields:
        What to hand to `train` as `on_progress`.
    """
    columns = (
        TextColumn("{task.description}"),
        BarColumn(bar_width=_BAR),
        TextColumn("{task.fields[text]}"),
    )
    console = Console(stderr=True)
    bars = Bars(*columns, console=console, disable=not console.is_terminal)
    short = [label if len(label) <= _LABEL else f"...{label[3 - _LABEL :]}" for label in labels]
    tasks = [bars.add_task(label, total=1.0, text="waiting") for label in short]
    beside = max(map(len, short), default=0) + _BAR + 3

    def show(progress: Progress) -> None:
        bars.start()
        text = _text(progress, console.width - beside)
        bars.update(tasks[progress.config], completed=progress.share, text=text)

    try:
        yield show
    finally:
        if bars.live.is_started:
            bars.stop()


def _text(p: Progress, width: int) -> str:
    """As much as a line has room for beside the bar: the least important parts are left out."""
    left = "done" if p.ended == p.runs else f"at most {_clock(p.seconds_left)} left"
    parts = {
        "episodes": f"{p.episodes:,.0f} episodes",
        "return": f"return {p.episode_return:.1f}",
        "converged": f"{p.converged}/{p.runs} converged",
        "speed": f"{p.steps_per_second / 1e3:,.0f}k steps/s",
        "left": left,
    }
    for dropped in ("speed", "episodes", "return", "converged"):
        if len(", ".join(parts.values())) > width:
            del parts[dropped]
    return ", ".join(parts.values())


def _clock(seconds: float) -> str:
    if seconds == float("inf"):
        return "?"
    minutes, seconds = divmod(round(seconds), 60)
    return f"{minutes}:{seconds:02}"
