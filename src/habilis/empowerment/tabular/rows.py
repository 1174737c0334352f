"""Unions of rows of words, several words in one instruction.

Written with loops over words, compilers keep to single words, so each piece of a row is loaded,
united and stored as one vector. A row is cut into pieces of eight, four, two or one words,
whichever is the widest that fits, two of them at a time; where its length is no multiple the last
piece overlaps the one before it. So rows of any length need no padding, and one compiled function
does for all.
"""

from typing import Any

import numpy as np
from jaxtyping import Int32, Int64, UInt8, UInt64
from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.extending import intrinsic

_NUMBER = ir.IntType(64)


def _unions(context, builder, signature, args, width, starts):
    """For one or two pieces of `width` words: the union of the successors', and that of s itself.

    The first arguments are next_state, sets and s. Two pieces at once read each successor once.
    """
    vector = ir.VectorType(_NUMBER, width)
    table, sets = (context.make_array(signature.args[k])(context, builder, args[k]) for k in (0, 1))
    actions, words = (builder.extract_value(one.shape, 1) for one in (table, sets))

    def place(data, row, start):
        first = builder.gep(data, [builder.add(builder.mul(row, words), start)])
        return builder.bitcast(first, vector.as_pointer())

    def loaded(row, start):
        value = builder.load(place(sets.data, row, start))
        value.align = 8
        return value

    before = builder.block
    loop, more, done = (builder.append_basic_block(name) for name in ("loop", "more", "done"))
    builder.branch(loop)
    builder.position_at_end(loop)
    a, unions = builder.phi(_NUMBER), [builder.phi(vector) for _ in starts]
    a.add_incoming(_NUMBER(0), before)
    builder.cbranch(builder.icmp_signed("<", a, actions), more, done)
    builder.position_at_end(more)
    entry = builder.gep(table.data, [builder.add(builder.mul(args[2], actions), a)])
    successor = builder.zext(builder.load(entry), _NUMBER)
    for start, union in zip(starts, unions, strict=True):
        union.add_incoming(ir.Constant(vector, [0] * width), before)
        union.add_incoming(builder.or_(union, loaded(successor, start)), more)
    a.add_incoming(builder.add(a, _NUMBER(1)), more)
    builder.branch(loop)
    builder.position_at_end(done)
    return [(union, loaded(args[2], w), w) for union, w in zip(unions, starts, strict=True)], place


def _as_expected(table, sets):
    """Whether arrays are laid out as is assumed here."""
    return (table.layout, table.dtype, sets.layout) == ("C", types.int32, "C")


def _stored(width: int, both: bool) -> Any:
    """An intrinsic that stores pieces of the union in out[s]; says if they differ from sets[s]."""

    def generate(context, builder, signature, args):
        out = context.make_array(signature.args[3])(context, builder, args[3])
        bits = ir.IntType(64 * width)
        pieces, place = _unions(context, builder, signature, args, width, args[4:])
        differs = ir.Constant(ir.IntType(1), 0)
        for union, old, start in pieces:
            builder.store(union, place(out.data, args[2], start)).align = 8
            difference = builder.bitcast(builder.xor(union, old), bits)
            one = builder.icmp_unsigned("!=", difference, ir.Constant(bits, 0))
            differs = builder.or_(differs, one)
        return differs

    whole = types.int64

    def one_piece(typing, table, sets, s, out, w):
        if _as_expected(table, sets):
            return types.boolean(table, sets, whole, out, whole), generate
        return None

    def two_pieces(typing, table, sets, s, out, w, v):
        if _as_expected(table, sets):
            return types.boolean(table, sets, whole, out, whole, whole), generate
        return None

    return intrinsic(two_pieces if both else one_piece)


def _counted(width: int) -> Any:
    """An intrinsic for how many bits a piece of the union has, its first `skip` words left out."""
    vector = ir.VectorType(_NUMBER, width)

    def generate(context, builder, signature, args):
        ((union, _, _),), _ = _unions(context, builder, signature, args, width, args[3:4])
        name, total = f"llvm.ctpop.v{width}i64", _NUMBER(0)
        population = cgutils.get_or_insert_function(
            builder.module, ir.FunctionType(vector, [vector]), name
        )
        ones = builder.call(population, [union])
        for lane in range(width):
            taken = builder.icmp_signed(">=", _NUMBER(lane), args[4])
            one = builder.extract_element(ones, ir.IntType(32)(lane))
            total = builder.add(total, builder.select(taken, one, _NUMBER(0)))
        return total

    def code(typing, table, sets, s, w, skip):
        if _as_expected(table, sets):
            return types.int64(table, sets, types.int64, types.int64, types.int64), generate
        return None

    return intrinsic(code)


_stored_8, _stored_4, _stored_2, _stored_1 = (_stored(width, False) for width in (8, 4, 2, 1))
_both_8, _both_4, _both_2 = (_stored(width, True) for width in (8, 4, 2))
_counted_8, _counted_4, _counted_2, _counted_1 = (_counted(width) for width in (8, 4, 2, 1))


def unite_rows(
    next_state: Int32[np.ndarray, "S A"],
    first: UInt8[np.ndarray, "S"],
    time: int,
    sets: UInt64[np.ndarray, "S W"],
    out: UInt64[np.ndarray, "S W"],
    begin: int,
    end: int,
) -> bool:
    """As `counting.unite`."""
    words = sets.shape[1]
    changed = False
    for s in range(begin, end):
        if first[s] > time:
            continue
        if words > 8:
            w = 0
            while words - w > 16:
                changed |= _both_8(next_state, sets, s, out, w, w + 8)
                w += 16
            changed |= _both_8(next_state, sets, s, out, min(w, words - 8), words - 8)
        elif words == 8:
            changed |= _stored_8(next_state, sets, s, out, 0)
        elif words > 4:
            changed |= _both_4(next_state, sets, s, out, 0, words - 4)
        elif words == 4:
            changed |= _stored_4(next_state, sets, s, out, 0)
        elif words == 3:
            changed |= _both_2(next_state, sets, s, out, 0, 1)
        elif words == 2:
            changed |= _stored_2(next_state, sets, s, out, 0)
        else:
            changed |= _stored_1(next_state, sets, s, out, 0)
    return changed


def count_rows(
    next_state: Int32[np.ndarray, "S A"],
    first: UInt8[np.ndarray, "S"],
    time: int,
    sets: UInt64[np.ndarray, "S W"],
    out: Int64[np.ndarray, "S"],
    begin: int,
    end: int,
) -> None:
    """As `counting.count_unions`."""
    words = sets.shape[1]
    for s in range(begin, end):
        if first[s] > time:
            continue
        if words >= 8:
            count = _counted_8(next_state, sets, s, words - 8, -words & 7)
            for w in range(0, words - 8, 8):
                count += _counted_8(next_state, sets, s, w, 0)
        elif words >= 4:
            count = _counted_4(next_state, sets, s, 0, 0)
            if words > 4:
                count += _counted_4(next_state, sets, s, words - 4, 8 - words)
        elif words >= 2:
            count = _counted_2(next_state, sets, s, 0, 0)
            if words > 2:
                count += _counted_2(next_state, sets, s, 1, 1)
        else:
            count = _counted_1(next_state, sets, s, 0, 0)
        out[s] = count
