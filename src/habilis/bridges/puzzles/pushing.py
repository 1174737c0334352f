"""One step of bodies that push each other, in compiled code."""

import numpy as np
from jaxtyping import Int64

from habilis.bridges.puzzles.bodies import STEPS, Collisions
from habilis.compiled import compiled


def pushed(
    collisions: Collisions,
    most: int,
    states: Int64[np.ndarray, "n bodies"],
    actions: Int64[np.ndarray, "n"],
) -> Int64[np.ndarray, "n bodies"]:
    """The corners of all bodies after the first, the agent, has moved by a cell.

    Args:
        collisions: of the bodies.
        most: how many bodies may be pushed at once; if there are more, nothing moves.
        states: the cells of their corners, `row * columns + column`.
        actions: one for each state.

    Returns:
        The next states.
    """
    stopped, outlines, meets = collisions.stopped, collisions.outlines, collisions.meets
    after = np.array(states, order="C")  # one that can be written: others were compiled for again
    steps, chosen = np.array(STEPS), np.ascontiguousarray(actions)
    _push(stopped, outlines, meets, steps, collisions.shape, most, after, chosen)
    return after


@compiled(lambda *args: args[-2].size * args[-2].shape[1])
def _push(stopped, outlines, meets, steps, shape, most, states, actions):
    count, bodies = states.shape
    rows, columns = shape
    row, column = np.empty(bodies, np.int64), np.empty(bodies, np.int64)
    moves, queue = np.empty(bodies, np.bool_), np.empty(bodies, np.int64)
    for place in range(count):
        action = actions[place]
        down, right = steps[action, 0], steps[action, 1]
        for body in range(bodies):
            row[body] = states[place, body] // columns
            column[body] = states[place, body] - row[body] * columns
            moves[body] = False
        moves[0], queue[0], moving, done, free = True, 0, 1, 0, True
        while done < moving and free:
            body = queue[done]
            done += 1
            if stopped[body, action, states[place, body]]:
                free = False
            for other in range(bodies):
                if moves[other] or not free:
                    continue
                far_down = row[other] - row[body] - down + rows
                far_right = column[other] - column[body] - right + columns
                if meets[outlines[body], outlines[other], far_down, far_right]:
                    moves[other] = True
                    queue[moving] = other
                    moving += 1
                    free = moving <= most + 1
        if free:
            for body in range(bodies):
                if moves[body]:
                    states[place, body] += down * columns + right
