"""Sets that spread through a graph, many columns of bits at a time.

Every node has a set, a bit a column, and a step gives each node the union of its neighbours' sets,

    X_0 given,   X_t(v) = union over neighbours u of v of X_{t-1}(u).

Columns do not depend on each other, so they are worked through in blocks: a block's sets stay in
the cache, its memory is bounded, and blocks run side by side. Within a block a step looks only at
nodes next to one whose set has just changed, as long as these are few, and sweeps over all nodes
when they are many. A block ends early at a fixed point, and at a period: from where its sets
repeat, only the remainder of the horizon matters.
"""

from dataclasses import dataclass
from typing import Any

import numpy as np
from jaxtyping import Int32, Int64, UInt64
from llvmlite import ir
from numba import types
from numba.extending import intrinsic

from habilis.compiled import compiled, part
from habilis.empowerment.tabular.columns import WORDS
from habilis.empowerment.tabular.recurring import FIRST_LOOK

_SWEEP = 0.05  # share of all edges next to changes from which a sweep over all nodes costs less
# What a block's progress consists of: places in `Block.state`.
_TIME, _END, _CHANGED, _TOUCHED, _STAMP, _SIDE, _TAKEN, _RETAKE, _DIFFERS, _PERIOD, _UNIONS = range(
    11
)


@dataclass(frozen=True)
class Graph:
    """Edges both ways, each once: `index[first[v]:first[v + 1]]` are the neighbours of v.

    Attributes:
        first, index: from where a node's set comes.
        back_first, back_index: to where a node's set goes.
    """

    first: Int64[np.ndarray, "nodes_and_one"]
    index: Int32[np.ndarray, "edges"]
    back_first: Int64[np.ndarray, "nodes_and_one"]
    back_index: Int32[np.ndarray, "edges"]

    @classmethod
    def of(cls, next_state: Int32[np.ndarray, "S A"]) -> "Graph":
        """Of a table: sets come from the next states."""
        return cls(*_edges(next_state))

    @property
    def turned(self) -> "Graph":
        """The same edges, along which sets go the other way."""
        return Graph(self.back_first, self.back_index, self.first, self.index)

    @property
    def nodes(self) -> int:
        return len(self.first) - 1


@dataclass(frozen=True)
class Block:
    """The memory that one block after another works in.

    Attributes:
        sets: uint64[3, nodes, WORDS]: the sets, room for the next ones, and earlier ones to
            compare with.
        lists: int32[5, nodes]: which nodes have changed, are looked at, and were ever touched; for
            each whether it was touched, and the step at which it was looked at last.
        state: int64, see the names above.
    """

    sets: UInt64[np.ndarray, "3 nodes words"]
    lists: Int32[np.ndarray, "5 nodes"]
    state: Int64[np.ndarray, "fields"]

    @classmethod
    def empty(cls, nodes: int) -> "Block":
        sets = np.zeros((3, nodes, WORDS), np.uint64)
        return cls(sets, np.zeros((5, nodes), np.int32), np.zeros(11, np.int64))

    @property
    def time(self) -> int:
        """How many steps are done."""
        return int(self.state[_TIME])

    @property
    def end(self) -> int:
        """How many steps there will be, as far as is known."""
        return int(self.state[_END])

    @property
    def period(self) -> int:
        """After how many steps the sets come again, 1 at a fixed point; 0 if that is not known."""
        return int(self.state[_PERIOD])

    @property
    def touched(self) -> Int32[np.ndarray, "k"]:
        """The nodes whose sets may not be empty."""
        return self.lists[2, : self.state[_TOUCHED]]


def current(block: Block) -> UInt64[np.ndarray, "nodes words"]:
    """The sets as they are now."""
    return block.sets[block.state[_SIDE]]


def begin(
    block: Block, nodes: Int32[np.ndarray, "k"], columns: Int32[np.ndarray, "k"], horizon: int
) -> None:
    """Clears what is left of the block before, and gives nodes their first columns."""
    _begin(block.sets, block.lists, block.state, nodes, columns)
    block.state[_END] = horizon


def advance(graph: Graph, block: Block, most_unions: int) -> bool:
    """Goes on until the horizon or about so many unions; says whether it is done."""
    _advance(
        graph.first,
        graph.index,
        graph.back_first,
        graph.back_index,
        block.sets,
        block.lists,
        block.state,
        most_unions,
    )
    return bool(block.state[_TIME] >= block.state[_END])


@compiled()
def _edges(next_state):
    """The distinct successors of each state, and its predecessors."""
    states, actions = next_state.shape
    seen = np.full(states, -1, np.int32)
    first = np.zeros(states + 1, np.int64)
    index = np.empty(states * actions, np.int32)
    back_first = np.zeros(states + 1, np.int64)
    edges = 0
    for s in range(states):
        for a in range(actions):
            t = next_state[s, a]
            if seen[t] != s:
                seen[t] = s
                index[edges] = t
                back_first[t + 1] += 1
                edges += 1
        first[s + 1] = edges
    index = index[:edges].copy()
    for s in range(states):
        back_first[s + 1] += back_first[s]
    filled = back_first[:-1].copy()
    back_index = np.empty(edges, np.int32)
    for s in range(states):
        for k in range(first[s], first[s + 1]):
            t = index[k]
            back_index[filled[t]] = s
            filled[t] += 1
    return first, index, back_first, back_index


@compiled()
def _begin(sets, lists, state, nodes, columns):
    changed, touched, is_touched, stamp = lists[0], lists[2], lists[3], lists[4]
    size = state[_TOUCHED]
    for k in range(size):
        s = touched[k]
        is_touched[s] = 0
        sets[0, s] = 0
        sets[1, s] = 0
        sets[2, s] = 0
    if state[_STAMP] > 2**30:
        stamp[:] = 0
        state[_STAMP] = 0
    kept = state[_STAMP]
    state[:] = 0
    state[_STAMP] = kept
    size = 0
    for k in range(len(nodes)):
        s = nodes[k]
        sets[0, s, columns[k] >> 6] |= np.uint64(1) << np.uint64(columns[k] & 63)
        if not is_touched[s]:
            is_touched[s] = 1
            touched[size] = s
            changed[size] = s
            size += 1
    state[_CHANGED] = size
    state[_TOUCHED] = size
    state[_RETAKE] = FIRST_LOOK


def _union_code(typing, index, begin, end, sets, s, out, k):
    """out[k] = union of sets[index[begin:end]]; says if that differs from sets[s].

    A row of eight words is one vector: written with loops over words, compilers keep to single
    words, which takes six times as long.
    """
    whole = types.int64
    signature = types.boolean(index, whole, whole, sets, whole, out, whole)

    def generate(context, builder, signature, args):
        number, row = ir.IntType(64), ir.VectorType(ir.IntType(64), WORDS)
        arrays = [
            context.make_array(signature.args[k])(context, builder, args[k]).data for k in (0, 3, 5)
        ]
        neighbours, sets, out = arrays
        begin, end, s, k = (args[i] for i in (1, 2, 4, 6))

        def row_at(base, place):
            first = builder.gep(base, [builder.mul(place, number(WORDS))])
            return builder.bitcast(first, row.as_pointer())

        def loaded(base, place):
            value = builder.load(row_at(base, place))
            value.align = 8
            return value

        before = builder.block
        loop, more, done = (builder.append_basic_block(name) for name in ("loop", "more", "done"))
        builder.branch(loop)
        builder.position_at_end(loop)
        edge, union = builder.phi(number), builder.phi(row)
        edge.add_incoming(begin, before)
        union.add_incoming(ir.Constant(row, [0] * WORDS), before)
        builder.cbranch(builder.icmp_signed("<", edge, end), more, done)
        builder.position_at_end(more)
        neighbour = builder.zext(builder.load(builder.gep(neighbours, [edge])), number)
        union.add_incoming(builder.or_(union, loaded(sets, neighbour)), more)
        edge.add_incoming(builder.add(edge, number(1)), more)
        builder.branch(loop)
        builder.position_at_end(done)
        builder.store(union, row_at(out, k)).align = 8
        bits = ir.IntType(64 * WORDS)
        difference = builder.bitcast(builder.xor(union, loaded(sets, s)), bits)
        return builder.icmp_unsigned("!=", difference, ir.Constant(bits, 0))

    return signature, generate


_union: Any = intrinsic(_union_code)


@compiled()
def _advance(first, index, back_first, back_index, sets, lists, state, most_unions):
    nodes = sets.shape[1]
    edges = len(index)
    changed, active, touched, is_touched, stamp = lists
    unions = 0
    while state[_TIME] < state[_END] and unions < most_unions:
        before, after = sets[state[_SIDE]], sets[1 - state[_SIDE]]
        size = state[_CHANGED]
        near = 0
        for k in range(size):
            near += back_first[changed[k] + 1] - back_first[changed[k]]
        grown = 0
        if near > _SWEEP * edges:
            unions += edges + nodes
            for s in range(nodes):
                if _union(index, first[s], first[s + 1], before, s, after, s):
                    changed[grown] = s
                    grown += 1
            state[_SIDE] = 1 - state[_SIDE]
            if state[_TOUCHED] < nodes:
                state[_TOUCHED] = nodes
                for s in range(nodes):
                    touched[s] = s
                    is_touched[s] = 1
        else:
            state[_STAMP] += 1
            now = state[_STAMP]
            looked = 0
            if state[_TIME] == 0:  # no step has made these sets: they may vanish in the first
                for k in range(size):
                    stamp[changed[k]] = now
                    active[looked] = changed[k]
                    looked += 1
            for k in range(size):
                for e in range(back_first[changed[k]], back_first[changed[k] + 1]):
                    s = back_index[e]
                    if stamp[s] != now:
                        stamp[s] = now
                        active[looked] = s
                        looked += 1
            unions += near + looked
            for k in range(looked):
                s = active[k]
                unions += first[s + 1] - first[s]
                if _union(index, first[s], first[s + 1], before, s, after, grown):
                    changed[grown] = s
                    grown += 1
            for k in range(grown):
                s = changed[k]
                for w in range(WORDS):
                    before[s, w] = after[k, w]
                if not is_touched[s]:
                    is_touched[s] = 1
                    touched[state[_TOUCHED]] = s
                    state[_TOUCHED] += 1
        state[_CHANGED] = grown
        state[_TIME] += 1
        if grown == 0:
            state[_PERIOD] = 1
            state[_END] = state[_TIME]
        elif state[_PERIOD] == 0:
            _look_back(sets, touched, state)
    state[_UNIONS] += unions


@part
def _look_back(sets, touched, state):
    """Finds a period: whether the sets are again those of some time before."""
    now, then = sets[state[_SIDE]], sets[2]
    time = state[_TIME]
    if state[_TAKEN] > 0:
        for i in range(state[_DIFFERS], state[_DIFFERS] + state[_TOUCHED]):
            k = i if i < state[_TOUCHED] else i - state[_TOUCHED]
            s = touched[k]
            for w in range(WORDS):
                if now[s, w] != then[s, w]:
                    state[_DIFFERS] = k
                    break
            else:
                continue
            break
        else:
            state[_PERIOD] = time - state[_TAKEN]
            state[_END] = time + (state[_END] - time) % state[_PERIOD]
            return
    if time == state[_RETAKE]:
        for k in range(state[_TOUCHED]):
            s = touched[k]
            for w in range(WORDS):
                then[s, w] = now[s, w]
        state[_TAKEN] = time
        state[_RETAKE] = time + max(FIRST_LOOK, time // 4)


def sizes_of(block: Block) -> Int64[np.ndarray, "nodes"]:
    """How many columns each node has now."""
    return _sizes(current(block), block.touched)


@compiled()
def _sizes(sets, touched):
    sizes = np.zeros(len(sets), np.int64)
    for s in touched:
        for w in range(WORDS):
            sizes[s] += _ones(sets[s, w])
    return sizes


def _ones_code(typing, word):
    """How many bits of a word are set."""

    def generate(context, builder, signature, args):
        return builder.ctpop(args[0])

    return types.uint64(types.uint64), generate


_ones: Any = intrinsic(_ones_code)
