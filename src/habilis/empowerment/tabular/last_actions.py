"""The last actions of sequences, which are followed side by side and never kept.

The beliefs before the last action or actions are at hand. From each of them all continuations
are followed, to what is observed in the end; of every sequence one number remains, the sum of
P ln P over its observations. With it,

    D(P || q) = sum over o of P(o) ln P(o) - sum over o of P(o) ln q(o),

and the right-hand sum is linear in the belief: for another q no sequence need be followed again.
Beliefs lie side by side in blocks, so that a processor's wide words work on several at once.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
from jaxtyping import Float64, Int32, Int64

from habilis.compiled import compile_now, compiled, part

LANES = 64
"""Beliefs in a block."""

_LEAST = float(np.finfo(np.float64).tiny)  # of what is possible: it must not round to 0
_LN2 = 0.6931471805599453


@dataclass(frozen=True)
class LastActions:
    """Beliefs, and what their continuations by the last r actions lead to.

    Sequences are numbered `belief * A**r + continuation`, the first of its actions first.

    Attributes:
        blocks: float64[B, N, LANES], the K beliefs over N states; zeros fill the last block.
        beliefs: K.
        remaining: r, 1 or more.
        actions: A.
        first, state, probability: transitions among the N states, as in `Successors`.
        last_first, observation, chance: the same of the last action, to observations.
        observations: O, how many there are.
        everywhere: whether every action is available in all of the states.
    """

    blocks: Float64[np.ndarray, "B N lanes"]
    beliefs: int
    remaining: int
    actions: int
    first: Int64[np.ndarray, "rows_and_one"]
    state: Int32[np.ndarray, "entries"]
    probability: Float64[np.ndarray, "entries"]
    last_first: Int64[np.ndarray, "last_rows_and_one"]
    observation: Int32[np.ndarray, "last_entries"]
    chance: Float64[np.ndarray, "last_entries"]
    observations: int
    everywhere: bool

    @property
    def sequences(self) -> int:
        """How many there are, those that cannot be carried out included."""
        return self.beliefs * self.actions**self.remaining

    @property
    def _steps(self) -> tuple[Any, ...]:
        """The actions and where they lead, as the kernels take them."""
        inner = self.first, self.state, self.probability
        last = self.last_first, self.observation, self.chance
        partial = not self.everywhere
        return self.remaining, self.actions, *inner, *last, self.observations, partial

    def neg_entropies(self) -> tuple[Float64[np.ndarray, "n"], Int64[np.ndarray, "O"]]:
        """The sum of P ln P of each sequence, -inf where an action is not surely available.

        And for each observation the sequence that makes it most likely.
        """
        return _neg_entropies(self.blocks, self.beliefs, *self._steps)

    def divergences(
        self, neg_entropies: Float64[np.ndarray, "n"], logs: Float64[np.ndarray, "O"]
    ) -> Float64[np.ndarray, "n"]:
        """D(P || q) of each sequence, given ln q."""
        value = _expected(self.last_first, self.observation, self.chance, logs[:, None])
        value = value.reshape(-1, self.actions)
        for _ in range(self.remaining - 1):
            before = _expected(self.first, self.state, self.probability, value)
            value = before.reshape(len(value), -1)
        return _divergences(self.blocks, value, neg_entropies)

    def rows(self, sequences: Int64[np.ndarray, "k"]) -> Float64[np.ndarray, "k O"]:
        """The distributions over observations of some sequences."""
        return _rows(self.blocks, sequences, *self._steps)


def side_by_side(matrix: Float64[np.ndarray, "K N"]) -> Float64[np.ndarray, "B N lanes"]:
    """Beliefs in blocks."""
    return _side_by_side(np.ascontiguousarray(matrix))


def compile_last_actions() -> None:
    """Leaves out the time as plain Python and as a compiler: what follows is timed."""
    compile_now(_side_by_side, _neg_entropies, _expected, _divergences, _rows)
    there = np.arange(2), np.zeros(1, np.int32), np.ones(1)
    tiny = LastActions(side_by_side(np.ones((1, 1))), 1, 1, 1, *there, *there, 1, True)
    tiny.divergences(tiny.neg_entropies()[0], np.zeros(1))
    tiny.rows(np.zeros(1, np.int64))


@compiled(lambda matrix: 2 * matrix.size)
def _side_by_side(matrix):
    count, width = matrix.shape
    blocks = np.zeros(((count + LANES - 1) // LANES, width, LANES))
    for i in range(count):
        block, lane = i // LANES, i % LANES
        for s in range(width):
            blocks[block, s, lane] = matrix[i, s]
    return blocks


def _following(blocks, beliefs, remaining, actions, first, state, *rest):
    outcomes = len(rest[3]) + (len(state) if remaining > 1 else 0)
    return len(blocks) * LANES * actions ** (remaining - 1) * (outcomes + 25 * rest[5] * actions)


@compiled(_following)
def _neg_entropies(
    blocks,
    beliefs,
    remaining,
    actions,
    first,
    state,
    probability,
    last_first,
    observation,
    chance,
    observations,
    partial,
):
    width = blocks.shape[1]
    endings = actions ** (remaining - 1)
    found = np.empty(beliefs * endings * actions)
    # Level t is where t of the remaining actions have led to.
    belief = np.zeros((remaining, width, LANES))
    reached = np.empty((remaining, width), np.int32)
    counts = np.zeros(remaining, np.int64)
    sure = np.ones((remaining, LANES), np.bool_)
    last = np.zeros((observations, LANES))
    seen = np.empty(observations, np.int32)
    last_sure = np.ones(LANES, np.bool_)
    marks = np.zeros(max(width, observations), np.int64)
    mark = 0
    power_bits = np.empty(LANES, np.uint64)
    mantissa_bits = np.empty(LANES, np.uint64)
    total = np.empty(LANES)
    most = np.zeros((observations, LANES))
    by = np.zeros((observations, LANES), np.int64)
    bits = last.view(np.uint64)
    for b in range(len(blocks)):
        counts[0] = 0
        for s in range(width):
            some = 0.0
            for lane in range(LANES):
                belief[0, s, lane] = blocks[b, s, lane]
                some += blocks[b, s, lane]
            if some > 0.0:
                reached[0, counts[0]] = s
                counts[0] += 1
        lanes = min(LANES, beliefs - b * LANES)
        for ending in range(endings):
            # Levels up to the first action that differs from the ending before are still right.
            begin, rest = remaining - 1, ending
            while begin > 0 and rest % actions == 0:
                rest //= actions
                begin -= 1
            if ending == 0:
                begin = 0
            for level in range(max(begin, 1), remaining):
                a = ending // actions ** (remaining - 1 - level) % actions
                mark += 1
                counts[level] = _apply(
                    belief[level - 1],
                    reached[level - 1],
                    counts[level - 1],
                    sure[level - 1],
                    first,
                    state,
                    probability,
                    actions,
                    a,
                    partial,
                    belief[level],
                    reached[level],
                    sure[level],
                    marks,
                    mark,
                )
            for a in range(actions):
                mark += 1
                count = _apply(
                    belief[remaining - 1],
                    reached[remaining - 1],
                    counts[remaining - 1],
                    sure[remaining - 1],
                    last_first,
                    observation,
                    chance,
                    actions,
                    a,
                    partial,
                    last,
                    seen,
                    last_sure,
                    marks,
                    mark,
                )
                for lane in range(LANES):
                    total[lane] = 0.0
                for k in range(count):
                    o = seen[k]
                    _add_neg_entropy(last[o], bits[o], power_bits, mantissa_bits, total)
                    _keep_most(last[o], (b * endings + ending) * actions + a, most[o], by[o])
                for lane in range(lanes):
                    place = ((b * LANES + lane) * endings + ending) * actions + a
                    found[place] = total[lane] if last_sure[lane] else -np.inf
    likeliest = np.empty(observations, np.int64)
    for o in range(observations):
        best = 0
        for lane in range(LANES):
            if most[o, lane] > most[o, best]:
                best = lane
        block, ending = by[o, best] // (endings * actions), by[o, best] % (endings * actions)
        likeliest[o] = (block * LANES + best) * endings * actions + ending
    return found, likeliest


@part
def _keep_most(values, number, most, by):
    for lane in range(len(values)):
        more = values[lane] > most[lane]
        most[lane] = values[lane] if more else most[lane]
        by[lane] = number if more else by[lane]


@part
def _apply(
    belief,
    reached,
    count,
    sure,
    first,
    state,
    probability,
    actions,
    a,
    partial,
    after,
    reached_after,
    sure_after,
    marks,
    mark,
):
    """Where an action leads from a block of beliefs; returns how many outcomes there are."""
    found, lanes = 0, belief.shape[1]  # a constant would be unrolled, and not use wide words
    if partial:
        for lane in range(lanes):
            sure_after[lane] = sure[lane]
    for i in range(count):
        s = reached[i]
        row = s * actions + a
        if partial and first[row] == first[row + 1]:
            for lane in range(lanes):
                if belief[s, lane] != 0.0:
                    sure_after[lane] = False
        for k in range(first[row], first[row + 1]):
            t, share = state[k], probability[k]
            if marks[t] != mark:
                marks[t] = mark
                reached_after[found] = t
                found += 1
                for lane in range(lanes):
                    after[t, lane] = 0.0
            if partial:
                for lane in range(lanes):
                    if belief[s, lane] != 0.0:
                        after[t, lane] += max(belief[s, lane] * share, _LEAST)
            else:
                for lane in range(lanes):
                    after[t, lane] += belief[s, lane] * share
    return found


@part
def _add_neg_entropy(x, bits, power_bits, mantissa_bits, total):
    """Adds x ln x, whose logarithm is a series in (m - 1) / (m + 1) with x = 2**e m.

    A polynomial, unlike a call of the C library, is computed for several numbers at once. ln 1 is
    0, and the error of ln x below 5e-16 (1 + |ln x|).
    """
    for lane in range(LANES):
        # The mantissa is to be from sqrt(1/2) to sqrt(2).
        shifted = bits[lane] + np.uint64(0x00095F6200000000)
        power = shifted >> np.uint64(52)
        power_bits[lane] = power | np.uint64(0x4330000000000000)  # as a float64: 2**52 + power
        mantissa_bits[lane] = bits[lane] - (power << np.uint64(52)) + np.uint64(0x3FF0000000000000)
    power_values, mantissas = power_bits.view(np.float64), mantissa_bits.view(np.float64)
    for lane in range(LANES):
        e = power_values[lane] - 4503599627371519.0  # 2**52 and the bias of 1023
        s = (mantissas[lane] - 1.0) / (mantissas[lane] + 1.0)
        z = s * s
        series = 1 / 11 + z * (1 / 13 + z * (1 / 15 + z * (1 / 17 + z * (1 / 19))))
        series = z * (1 / 3 + z * (1 / 5 + z * (1 / 7 + z * (1 / 9 + z * series))))
        total[lane] += x[lane] * (e * _LN2 + (2.0 * s + 2.0 * s * series))


@compiled(lambda first, state, probability, value: 2 * len(state) * value.shape[1])
def _expected(first, state, probability, value):
    """The expected value after each action in each state, [S * A, ...]."""
    rows, width = len(first) - 1, value.shape[1]
    expected = np.zeros((rows, width))
    for row in range(rows):
        for k in range(first[row], first[row + 1]):
            for j in range(width):
                expected[row, j] += probability[k] * value[state[k], j]
    return expected


@compiled(lambda blocks, value, neg_entropies: blocks.size * value.shape[1])
def _divergences(blocks, value, neg_entropies):
    width, endings = value.shape
    found = np.empty(len(neg_entropies))
    mean = np.empty((endings, LANES))
    beliefs = len(neg_entropies) // endings
    for b in range(len(blocks)):
        for j in range(endings):
            for lane in range(LANES):
                mean[j, lane] = 0.0
        for s in range(width):
            for j in range(endings):
                weight = value[s, j]
                for lane in range(LANES):
                    mean[j, lane] += weight * blocks[b, s, lane]
        for lane in range(min(LANES, beliefs - b * LANES)):
            for j in range(endings):
                place = (b * LANES + lane) * endings + j
                found[place] = neg_entropies[place] - mean[j, lane]
    return found


@compiled(lambda blocks, sequences, remaining, *rest: len(sequences) * remaining * len(rest[2]))
def _rows(
    blocks,
    sequences,
    remaining,
    actions,
    first,
    state,
    probability,
    last_first,
    observation,
    chance,
    observations,
    partial,
):
    width, endings = blocks.shape[1], actions**remaining
    rows = np.zeros((len(sequences), observations))
    before, after = np.empty(width), np.empty(width)
    for i in range(len(sequences)):
        number, ending = sequences[i] // endings, sequences[i] % endings
        for s in range(width):
            before[s] = blocks[number // LANES, s, number % LANES]
        for level in range(1, remaining):
            a = ending // actions ** (remaining - level) % actions
            for s in range(width):
                after[s] = 0.0
            for s in range(width):
                if before[s] != 0.0:
                    for k in range(first[s * actions + a], first[s * actions + a + 1]):
                        share = before[s] * probability[k]
                        after[state[k]] += max(share, _LEAST) if partial else share
            before, after = after, before
        a = ending % actions
        for s in range(width):
            if before[s] != 0.0:
                for k in range(last_first[s * actions + a], last_first[s * actions + a + 1]):
                    share = before[s] * chance[k]
                    rows[i, observation[k]] += max(share, _LEAST) if partial else share
    return rows
