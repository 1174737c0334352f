"""A process that trains one configuration in a folder, and tells how far it has come.

python -m habilis.studio.trainer FOLDER

Standard input has one line, the settings as JSON. Standard output has a line for every stretch of
training, and one for how it ended: `{"ended": true}`, `{"stopped": true}` or `{"error": one line}`.
"""

import json
import sys
from pathlib import Path

from habilis.learning.config import Config
from habilis.learning.runs import Progress
from habilis.learning.train import train

CHECKPOINT_SECONDS = 1.0


def main(folder: str) -> None:
    def show(progress: Progress) -> None:
        told = {"share": progress.share, "steps_per_second": progress.steps_per_second}
        print(json.dumps(told), flush=True)

    try:
        config = Config.from_dict(json.loads(sys.stdin.readline()))
        train(config, show, out=Path(folder), checkpoint_seconds=CHECKPOINT_SECONDS)
    except KeyboardInterrupt:
        print(json.dumps({"stopped": True}))
    except (ValueError, FloatingPointError, OSError) as error:
        print(json.dumps({"error": str(error)}))
    else:
        print(json.dumps({"ended": True}))


if __name__ == "__main__":
    main(*sys.argv[1:])
