"""Limits of the studio, which has to respond quickly. The page has them from the greeting only."""

SIDES = (4, 30)
"""The smallest and largest number of rows, and of columns, of a map."""
THINGS = 4
"""Tools of a map, and objects."""
HORIZON = 10
DISCOUNT = 0.95
"""Of effective empowerment: 20 steps ahead in the mean."""
SLACK = 10
FRAMES = 1_000
"""Placements of a film, and of a game as code."""
TOOLS = 100
"""Tools whose averages are shown as code."""
SLIP = 0.5
TOOL_SLIP = 1.0

REACHED = 300_000
"""Placements that can ever be reached, for kinds of empowerment that need all of them."""
NUMBERS = 30_000_000
"""Of effective empowerment: observations times states."""
OBSERVATIONS = 16
"""Of closed-loop empowerment with random outcomes: how many are possible from a cell."""
PATIENCE = 240.0
"""Seconds up to which a landscape is computed cell by cell, by an estimate."""

PAIR = 1_000_000
"""Placements of a pair of a tool and an object, which are compared exactly."""

BOARD_SIDE = 60
"""The most rows, and columns, of a board: a puzzle or environment that the studio shows."""
BOARD_STATES = 200_000
"""Of an environment, which is enumerated whole; and of a puzzle, those within the horizon."""
FACTORS = 64

MESSAGE = 64 * 1024
"""Characters of a message."""
CLIENTS = 200

SECONDS = 60.0
"""For one step of a computation, by an estimate or else by the clock."""
GIB = 2.0
DRAWN, FEWEST = 400, 30
"""Largest and smallest number of random placements that an average is estimated from."""

TRAINING = {
    "runs": 10,
    "episodes": 100_000,
    "seed": 2**32 - 1,
    "placements": 400_000,
    "at_once": 2,
    "waiting": 8,
}
"""Of a training; `at_once` may train in parallel while `waiting` more are queued."""
RELOADED = 15.0
"""Seconds for which a training waits for a page to follow it, once its own is gone."""
LISTED = 200
"""Kept trainings that a page lists, newest first."""
