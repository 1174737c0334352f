"""Runs side by side on a device, which stay there from one stretch of training to the next."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np
from jaxtyping import Array, Bool, Int, Key, UInt32

from habilis.learning.lanes import Lane, Settings, start_lanes

if TYPE_CHECKING:
    from habilis.learning.jobs import Job


class Seat(NamedTuple):
    """A run, by its job and its number there."""

    job: "Job"
    run: int


@dataclass(frozen=True, eq=False)
class Stack:
    """Runs side by side.

    Attributes:
        device: where they are.
        settings, lanes: with a leading axis of lanes.
    """

    device: Any
    settings: Settings
    lanes: Lane

    @property
    def width(self) -> int:
        return len(self.lanes.updates)

    def lane(self, place: int) -> Lane:
        """One of the lanes, in NumPy arrays. JAX keeps what it has copied for the next one."""
        return jax.tree.map(lambda leaf: np.asarray(leaf)[place], self.lanes)

    def alone(self, place: int) -> Lane:
        """A copy of one of the lanes, which does not keep the others in memory.

        It stays on the device, without a transfer to wait for.
        """
        if _on_host(self.device):
            return jax.tree.map(np.copy, self.lane(place))
        return _picked(self.lanes, np.int32(place))


class InStack(NamedTuple):
    """Where the lane of a run is."""

    stack: Stack
    place: int

    def lane(self) -> Lane:
        return self.stack.lane(self.place)


def side_by_side(seats: Sequence[Seat], width: int, device: Any) -> tuple[Stack, list[int]]:
    """Runs of one program and world side by side, as wide as wanted, and the place of each.

    The other lanes are repetitions, or of runs that have left, and are ignored. What is
    already there is used as it is, and what is on the device does not leave it.
    """
    held = [seat.job.lanes.get(seat.run) for seat in seats]
    first = held[0]
    if isinstance(first, InStack):
        stack = first.stack
        places = [at.place for at in held if isinstance(at, InStack) and at.stack is stack]
        if len(places) == len(seats) and (stack.device, stack.width) == (device, width):
            return stack, places
    make = stacked if _on_host(device) else merged
    return make(seats, width, device), list(range(len(seats)))


def stacked(seats: Sequence[Seat], width: int, device: Any) -> Stack:
    """The seats in their order, put together in NumPy."""
    full = [seats[i % len(seats)] for i in range(width)]
    parts = [s.job.settings for s in full], [s.job.lane(s.run) for s in full]
    return Stack(device, *jax.device_put(tuple(map(_in_numpy, parts)), device))


def merged(seats: Sequence[Seat], width: int, device: Any) -> Stack:
    """The seats in their order, put together on the device.

    One stack after the other gives its lanes. So there is one program for each two widths, and not
    one for each set of stacks from which a batch comes.
    """
    sources: dict[int, tuple[Stack, list[tuple[int, int]]]] = {}
    fresh, others = list[int](), list[int]()
    for i, (job, run) in enumerate(seats):
        held = job.lanes.get(run)
        if isinstance(held, InStack):
            sources.setdefault(id(held.stack), (held.stack, []))[1].append((i, held.place))
        else:
            (fresh if held is None else others).append(i)
    if fresh:
        stack = _started([seats[i] for i in fresh], width, device)
        sources[-1] = stack, list(zip(fresh, range(len(fresh)), strict=True))
    if others:
        stack = stacked([seats[i] for i in others], width, device)
        sources[-2] = stack, list(zip(others, range(len(others)), strict=True))
    into: Any = None
    for stack, pairs in sources.values():
        places, here = np.zeros(width, np.int32), np.zeros(width, bool)
        for i, place in pairs:
            places[i :: len(seats)], here[i :: len(seats)] = place, True
        source = jax.device_put((stack.settings, stack.lanes), device)
        into = _taken(source, places) if into is None else _filled(into, source, places, here)
    settings, lanes = into
    return Stack(device, settings, lanes)


def _started(seats: Sequence[Seat], width: int, device: Any) -> Stack:
    """Runs before their first step, all started at once."""
    full = [seats[i % len(seats)] for i in range(width)]
    job = seats[0].job
    seeds = np.array([seat.job.config.seed for seat in full], np.uint32)
    numbers = np.array([seat.job.numbers[seat.run] for seat in full], np.uint32)
    dynamics, seeds, numbers = jax.device_put((job.dynamics[0], seeds, numbers), device)
    lanes = start_lanes(dynamics, job.program, _keys(seeds, numbers))
    settings = jax.device_put(_in_numpy([seat.job.settings for seat in full]), device)
    return Stack(device, settings, lanes)


def _in_numpy(trees: list[Any]) -> Any:
    return jax.tree.map(lambda *leaves: np.stack(leaves), *trees)


def _on_host(device: Any) -> bool:
    """Whether NumPy sees the device's memory, and copies as fast as a compiled program."""
    return device.platform == "cpu"


@jax.jit
def _keys(seeds: UInt32[Array, "n"], numbers: UInt32[Array, "n"]) -> Key[Array, "n"]:
    """`Job.start`'s keys."""
    return jax.vmap(lambda seed, number: jax.random.fold_in(jax.random.key(seed), number))(
        seeds, numbers
    )


@jax.jit
def _picked(lanes: Lane, place: Int[Array, ""]) -> Lane:
    return jax.tree.map(lambda leaf: leaf[place], lanes)


@jax.jit
def _taken(source: Any, places: Int[Array, "n"]) -> Any:
    return jax.tree.map(lambda leaf: leaf[places], source)


@jax.jit
def _filled(into: Any, source: Any, places: Int[Array, "n"], here: Bool[Array, "n"]) -> Any:
    def one(old: Array, new: Array) -> Array:
        return jnp.where(here.reshape(-1, *[1] * (old.ndim - 1)), new[places], old)

    return jax.tree.map(one, into, source)


def finite(stack: Stack) -> Bool[np.ndarray, "lanes"]:
    """Of which lanes all that was learned is finite."""
    learned = stack.lanes.train_state, stack.lanes.novelty
    if _on_host(stack.device):
        return _finite(jax.tree.map(np.asarray, learned), np)
    return np.asarray(_finite_there(learned))


def _finite(learned: Any, xp: Any) -> Any:
    found: Any = True
    for leaf in jax.tree.leaves(learned):
        found = xp.isfinite(leaf).all(axis=tuple(range(1, leaf.ndim))) & found
    return found


@jax.jit
def _finite_there(learned: Any) -> Bool[Array, "lanes"]:
    return _finite(learned, jnp)
