"""Compiled parts of effective empowerment: products with a policy's matrix, and its channels.

A channel's row, of a state and an action, is made of three parts with weights: what is observed at
once, what after one step, and the discounted observations of the next states. The matrices are the
three arrays of scipy's CSR format.
"""

import numpy as np

from habilis.compiled import compiled, part


def _of_rows(at_once, seen, moves, discounted, weights, policy, states, *rest):
    """Roughly the operations of all rows of the channel."""
    start, stop = rest[-2:]
    each = 4 + len(moves[2]) / max(len(moves[0]) - 1, 1)
    return (stop - start) * policy.shape[1] * discounted.shape[1] * each


def _of_iterations(*args):
    return 50 * _of_rows(*args)


@compiled(lambda first, column, value, old, *rest: len(value) * old.shape[1])
def add_product(first, column, value, old, factor, new, start, stop):
    """new[start:stop] += factor * matrix[start:stop] @ old."""
    for row in range(start, stop):
        for place in range(first[row], first[row + 1]):
            weight, other = factor * value[place], column[place]
            for o in range(old.shape[1]):
                new[row, o] += weight * old[other, o]


@part
def channel_row(at_once, seen, moves, discounted, weights, state, action, actions, row):
    """Writes P(o | state, action) into `row`."""
    row[:] = 0.0
    for place in range(at_once[0][state], at_once[0][state + 1]):
        row[at_once[1][place]] += weights[0] * at_once[2][place]
    pair = state * actions + action
    for place in range(seen[0][pair], seen[0][pair + 1]):
        row[seen[1][place]] += weights[1] * seen[2][place]
    if weights[2] > 0:
        for place in range(moves[0][pair], moves[0][pair + 1]):
            weight, other = weights[2] * moves[2][place], moves[1][place]
            for o in range(len(row)):
                row[o] += weight * discounted[other, o]


@compiled(_of_rows)
def add_information(at_once, seen, moves, discounted, weights, policy, states, nats, start, stop):
    """Adds what these observations contribute to I(A; O), A by the policy, to nats[start:stop]."""
    actions = policy.shape[1]
    rows = np.empty((actions, discounted.shape[1]))
    mean = np.empty(discounted.shape[1])
    for place in range(start, stop):
        state = states[place]
        mean[:] = 0.0
        for action in range(actions):
            if policy[state, action] > 0:
                row = rows[action]
                channel_row(at_once, seen, moves, discounted, weights, state, action, actions, row)
                mean += policy[state, action] * row
        total = 0.0
        for action in range(actions):
            if policy[state, action] > 0:
                for o in range(len(mean)):
                    if rows[action, o] > 0:
                        ratio = np.log(rows[action, o] / mean[o])
                        total += policy[state, action] * rows[action, o] * ratio
        nats[place] += total


@compiled(_of_iterations)
def add_capacity(
    at_once, seen, moves, discounted, weights, available, states, sought, lower, upper, start, stop
):
    """Writes bounds on max I(A; O) over distributions of available actions, in nats.

    By the iteration of Blahut and Arimoto with a step that grows as long as I does, until they are
    `sought` apart or after 200 steps.
    """
    actions = available.shape[1]
    rows = np.empty((actions, discounted.shape[1]))
    entropy, divergence = np.empty(actions), np.empty(actions)
    inputs, mean = np.empty(actions), np.empty(discounted.shape[1])
    for place in range(start, stop):
        state = states[place]
        count = 0
        for action in range(actions):
            if available[state, action]:
                row = rows[count]
                channel_row(at_once, seen, moves, discounted, weights, state, action, actions, row)
                entropy[count] = 0.0
                for o in range(len(row)):
                    if row[o] > 0:
                        entropy[count] += row[o] * np.log(row[o])
                count += 1
        inputs[:count] = 1 / count
        lower[place], upper[place] = 0.0, np.inf
        before, step = 0.0, 2.0
        for _ in range(200):
            mean[:] = 0.0
            for x in range(count):
                if inputs[x] > 1e-12:
                    mean += inputs[x] * rows[x]
            for o in range(len(mean)):
                mean[o] = np.log(max(mean[o], 1e-300))
            information, most = 0.0, 0.0
            for x in range(count):
                divergence[x] = entropy[x]
                for o in range(len(mean)):
                    divergence[x] -= rows[x, o] * mean[o]
                information += inputs[x] * divergence[x]
                most = max(most, divergence[x])
            lower[place] = max(lower[place], information)
            upper[place] = min(upper[place], max(most, lower[place]))
            if upper[place] - lower[place] <= sought:
                break
            step = step * 1.5 if information > before else 2.0
            before, total = information, 0.0
            for x in range(count):
                inputs[x] *= np.exp(step * (divergence[x] - most))
                total += inputs[x]
            for x in range(count):
                inputs[x] = max(inputs[x] / total, 1e-300)
