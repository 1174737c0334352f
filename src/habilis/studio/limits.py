"""What the studio computes at most, for it answers while somebody waits."""

SIDES = (4, 30)
"""Rows or columns of a map, least and most."""
THINGS = 4
"""Tools, and objects, on a map."""
HORIZON = 10
SLIP = 0.5

MESSAGE = 64 * 1024
"""Characters of a message."""
CLIENTS = 200

SECONDS = 60.0
"""That one step of a computation may take, by an estimate or else by the clock."""
GIB = 2.0
DRAWN, FEWEST = 400, 30
"""Placements that an average is estimated from, where all of them are too many; and at least."""

TRAINING = {
    "runs": 10,
    "episodes": 100_000,
    "placements": 400_000,
    "at_once": 2,
    "waiting": 8,
}
"""Of a training; how many train at once, and how many may wait for that."""
LISTED = 200
"""Kept trainings of which a page is told, the latest."""
