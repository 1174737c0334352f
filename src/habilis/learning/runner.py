"""Training: from configurations to runs."""

from collections.abc import Callable, Sequence
from pathlib import Path
from typing import overload

from habilis.learning.batches import check_lanes, train_jobs
from habilis.learning.config import Config
from habilis.learning.jobs import Job
from habilis.learning.runs import Progress, Run
from habilis.learning.training_problem import prepared

OnProgress = Callable[[Progress], None]


@overload
def train(
    config: Config,
    on_progress: OnProgress | None = ...,
    *,
    out: str | Path | None = ...,
    resume: bool = ...,
    checkpoint_seconds: float = ...,
    lanes: int | None = ...,
) -> Run: ...
@overload
def train(
    config: Sequence[Config],
    on_progress: OnProgress | None = ...,
    *,
    lanes: int | None = ...,
) -> list[Run]: ...


def train(
    config: Config | Sequence[Config],
    on_progress: OnProgress | None = None,
    *,
    out: str | Path | None = None,
    resume: bool = False,
    checkpoint_seconds: float = 10.0,
    lanes: int | None = None,
) -> Run | list[Run]:
    """Trains all runs of one or several configurations, side by side.

    Runs advance in batches of lanes, batches on as many threads as there are processors, or two
    for each GPU. A run ends by itself when it has converged
    (`convergence.episodes_to_convergence`) or has used up its episodes; one that waits takes
    its place. On a CPU, and wherever `lanes` is given, a run is the same, bit for bit, whatever
    trains beside it.

    Args:
        config: one configuration, or several.
        on_progress: called after every stretch of training.
        out: a new folder in which to keep checkpoints and, at the end, the run; for one
            configuration.
        resume: whether to go on from the last checkpoint in that folder, if there is one. The
            run that comes out is the same, byte for byte, as without the interruption; on a GPU,
            if `lanes` is given.
        checkpoint_seconds: how often to write a checkpoint; the last two are kept.
        lanes: how many runs wide every batch is; one that is not full is filled up. XLA rounds
            differently at another width, so it gives another run. By default five on a CPU; on a
            GPU the smallest power of two that holds the runs that wait, from eight to 512, and
            five if no more than five wait.

    Returns:
        A `Run`, or a list of them in the order of the configurations.

    Raises:
        ValueError: a world, tool or sensor that does not exist, a goal out of reach, a folder
            that cannot be used, or `lanes` that is no whole number from 1 to 65,536.
        KeyboardInterrupt: Ctrl-C or SIGTERM; with `out`, after a last checkpoint.
        FloatingPointError: a loss or a parameter was not finite.
    """
    check_lanes(lanes)
    if isinstance(config, Config):
        if out is None:
            return _trained([Job.of(0, *prepared(config))], on_progress, lanes)[0]
        from habilis.learning.sessions import train_in_folder

        return train_in_folder(config, on_progress, Path(out), resume, checkpoint_seconds, lanes)
    if out is not None:
        raise ValueError("out is for one configuration; train several without it, or one by one")
    jobs = [Job.of(i, *prepared(one)) for i, one in enumerate(config)]
    return _trained(jobs, on_progress, lanes)


def _trained(jobs: list[Job], on_progress: OnProgress | None, lanes: int | None) -> list[Run]:
    train_jobs(jobs, on_progress, lanes=lanes)
    return [job.result() for job in jobs]
