"""A process that trains one configuration in a folder, and tells how far it has come.

python -m habilis.studio.trainer FOLDER

Standard input has one line, the settings as JSON. Standard output has a line for every stretch of
training, and one for how it ended: `{"ended": true}`, `{"stopped": true}` or `{"error": one line}`.
"""

import json
import os
import sys
from pathlib import Path
from typing import Any

from habilis.learning.config import Config
from habilis.learning.runs import Progress
from habilis.learning.train import train
from habilis.studio.limits import TRAINING
from habilis.worlds.placements import start_of
from habilis.worlds.reach import TooManyPlacementsError, reachable
from habilis.worlds.world import World, load_world

CHECKPOINT_SECONDS = 1.0


def main(folder: str) -> None:
    answers = os.fdopen(os.dup(sys.stdout.fileno()), "w")
    os.dup2(sys.stderr.fileno(), sys.stdout.fileno())  # somebody's own tool may print

    def tell(**told: Any) -> None:
        print(json.dumps(told), file=answers, flush=True)

    def show(progress: Progress) -> None:
        tell(share=progress.share, steps_per_second=progress.steps_per_second)

    try:
        config = Config.from_dict(json.loads(sys.stdin.readline()))
        check_reach(load_world(config.world))
        train(config, show, out=Path(folder), checkpoint_seconds=CHECKPOINT_SECONDS)
    except KeyboardInterrupt:
        tell(stopped=True)
    except (ValueError, FloatingPointError, OSError) as error:
        tell(error=str(error))
    else:
        tell(ended=True)


def check_reach(world: World) -> None:
    """Refuses maps on which tools that are put down here and there make too many placements.

    How many there can be is known beforehand only where a tool stays in hand.

    Raises:
        ValueError: naming the map.
    """
    if not world.drop:
        return
    most = TRAINING["placements"]
    try:
        reachable(world, start_of(world), None, most)
    except TooManyPlacementsError:
        raise ValueError(
            f"{world.name}: tools put down here and there make more than {most:,} placements; take "
            "things away, or make the map smaller"
        ) from None


if __name__ == "__main__":
    main(*sys.argv[1:])
