"""Unions of rows of words, several words in one instruction.

Written with loops over words, compilers keep to single words, so each piece of a row is loaded,
united and stored as one vector. A row is cut into pieces of eight, four, two or one words,
whichever is the widest that fits; where its length is no multiple the last piece overlaps the one
before it. So rows of any length need no padding, and one compiled function does for all.
"""

from typing import Any

import numpy as np
from jaxtyping import Int32, Int64, UInt8, UInt64
from llvmlite import ir
from numba import types
from numba.core import cgutils
from numba.extending import intrinsic

_NUMBER = ir.IntType(64)


def _piece(width: int, counted: bool) -> Any:
    """An intrinsic for `width` words from word w on of the union of the successors' rows.

    Either (table, sets, s, w, out) stores them in out[s] and says if they differ from sets[s]; or
    (table, sets, s, w, skip) says how many bits they have, the first `skip` words left out.
    """
    vector, bits = ir.VectorType(_NUMBER, width), ir.IntType(64 * width)

    def code(typing, table, sets, s, w, last):
        if (table.layout, table.dtype, sets.layout) != ("C", types.int32, "C"):
            return None
        result = types.int64 if counted else types.boolean
        return result(table, sets, types.int64, types.int64, last), generate

    def generate(context, builder, signature, args):
        def array(k):
            return context.make_array(signature.args[k])(context, builder, args[k])

        table, sets, s, w = array(0), array(1), args[2], args[3]
        actions = builder.extract_value(table.shape, 1)
        words = builder.extract_value(sets.shape, 1)

        def place(data, row):
            first = builder.gep(data, [builder.add(builder.mul(row, words), w)])
            return builder.bitcast(first, vector.as_pointer())

        def loaded(row):
            value = builder.load(place(sets.data, row))
            value.align = 8
            return value

        before = builder.block
        loop, more, done = (builder.append_basic_block(name) for name in ("loop", "more", "done"))
        builder.branch(loop)
        builder.position_at_end(loop)
        a, union = builder.phi(_NUMBER), builder.phi(vector)
        a.add_incoming(_NUMBER(0), before)
        union.add_incoming(ir.Constant(vector, [0] * width), before)
        builder.cbranch(builder.icmp_signed("<", a, actions), more, done)
        builder.position_at_end(more)
        entry = builder.gep(table.data, [builder.add(builder.mul(s, actions), a)])
        successor = builder.zext(builder.load(entry), _NUMBER)
        union.add_incoming(builder.or_(union, loaded(successor)), more)
        a.add_incoming(builder.add(a, _NUMBER(1)), more)
        builder.branch(loop)
        builder.position_at_end(done)
        if not counted:
            builder.store(union, place(array(4).data, s)).align = 8
            difference = builder.bitcast(builder.xor(union, loaded(s)), bits)
            return builder.icmp_unsigned("!=", difference, ir.Constant(bits, 0))
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

    return intrinsic(code)


_united_8, _united_4, _united_2, _united_1 = (_piece(width, False) for width in (8, 4, 2, 1))
_counted_8, _counted_4, _counted_2, _counted_1 = (_piece(width, True) for width in (8, 4, 2, 1))


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
        if words >= 8:
            for w in range(0, words - 8, 8):
                changed |= _united_8(next_state, sets, s, w, out)
            changed |= _united_8(next_state, sets, s, words - 8, out)
        elif words >= 4:
            changed |= _united_4(next_state, sets, s, 0, out)
            if words > 4:
                changed |= _united_4(next_state, sets, s, words - 4, out)
        elif words >= 2:
            changed |= _united_2(next_state, sets, s, 0, out)
            if words > 2:
                changed |= _united_2(next_state, sets, s, 1, out)
        else:
            changed |= _united_1(next_state, sets, s, 0, out)
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
