"""A process that trains one configuration in a folder, and reports its progress.

python -m habilis.studio.training_process FOLDER

Standard input has one line, the settings as JSON. Standard output has a line for every chunk of
training, and one for its end: `{"ended": true}`, `{"stopped": true}` or `{"error": one line}`.
"""

import json
import os
import sys
from pathlib import Path
from typing import Any

from habilis.learning.config import Config
from habilis.learning.runner import train
from habilis.learning.runs import Progress
from habilis.learning.sources import map_of, source_of
from habilis.studio.child_processes import find_last_in_working_directory
from habilis.studio.limits import TRAINING
from habilis.worlds.placements import start_of
from habilis.worlds.reach import TooManyPlacementsError, reachable
from habilis.worlds.world import World

CHECKPOINT_SECONDS = 1.0


def main(folder: str) -> None:
    find_last_in_working_directory()
    answers = os.fdopen(os.dup(sys.stdout.fileno()), "w")
    os.dup2(sys.stderr.fileno(), sys.stdout.fileno())  # a custom tool may print

    def report(**fields: Any) -> None:
        print(json.dumps(fields), file=answers, flush=True)

    def show(progress: Progress) -> None:
        report(share=progress.share, steps_per_second=progress.steps_per_second)

    try:
        config = Config.from_dict(json.loads(sys.stdin.readline()))
        check_reach(map_of(source_of(config)))
        train(config, show, out=Path(folder), checkpoint_seconds=CHECKPOINT_SECONDS)
    except KeyboardInterrupt:
        report(stopped=True)
    except (ValueError, FloatingPointError, OSError) as error:
        report(error=str(error))
    else:
        report(ended=True)


def check_reach(world: World) -> None:
    """Refuses maps on which dropped tools make too many placements.

    Their number is known in advance only if a tool stays in hand.

    Raises:
        ValueError: the map has too many placements.
    """
    if not world.drop:
        return
    most = TRAINING["placements"]
    try:
        reachable(world, start_of(world), None, most)
    except TooManyPlacementsError:
        raise ValueError(
            f"{world.name}: dropped tools make more than {most:,} placements; remove things, "
            "or make the map smaller"
        ) from None


if __name__ == "__main__":
    main(*sys.argv[1:])
