"""Limits on the cost of a computation, and the error for exceeding them."""

import time
from collections.abc import Callable
from dataclasses import dataclass
from math import inf
from typing import Any


@dataclass(frozen=True)
class Limits:
    """Limits on the cost of a computation.

    Attributes:
        gib: memory in use at once, in GiB.
        seconds: time.
        otherwise: what else can be done where it would cost more, as the error says it; "" where
            nothing can.
    """

    gib: float
    seconds: float
    otherwise: str = ""


MAX_GIB, MAX_SECONDS = 8.0, 3600.0
"""The default limits."""

UNLIMITED = Limits(inf, inf)

_TRIAL = 0.5  # seconds before the rest is first estimated from what they did
_STALL = 2.0  # seconds up to which a single estimate refuses nothing
_STARTED = 10.0  # seconds after which a computation is no longer refused

Progress = Callable[[float], None]
"""Receives the share that is done, from 0 to 1."""


def unwatched(share: float) -> None:
    """A progress callback that does nothing."""


class TooMuchError(ValueError):
    """A computation that would cost more than it may.

    Attributes:
        horizon: that was asked for.
        fitting: the largest that fits; -1 where none does.
    """

    def __init__(self, message: str, horizon: int, fitting: int):
        super().__init__(message)
        self.horizon, self.fitting = horizon, fitting

    def __reduce__(self) -> tuple[Any, ...]:
        """For pickles, by which errors come back from other processes."""
        return type(self), (self.args[0], self.horizon, self.fitting)


def too_much(
    horizon: int,
    fitting: int,
    limits: Limits,
    cost: str = "turns out to take more memory",
    estimated: bool = False,
) -> TooMuchError:
    """The error that names the largest horizon that fits, and what can be done."""
    about = "about " if estimated else ""
    remedies = ["raise max_gib or max_seconds", *filter(None, [limits.otherwise])]
    best = "no horizon fits"
    if fitting >= 0:
        best = f"the largest horizon that fits is {about}{fitting}"
        remedies = ["use it", *remedies]
    *first, last = remedies
    steps = f"{', '.join(first)}, or {last}" if first else last
    message = (
        f"horizon {horizon} {cost}; the limits are {limits.gib:g} GiB and {limits.seconds:g} s, "
        f"and {best}: {steps}"
    )
    return TooMuchError(message, horizon, fitting)


def takes(gib: float, seconds: float) -> str:
    """The cost of a computation as the error words it."""
    return f"takes about {gib:.3g} GiB and {seconds:.3g} s"


def check_memory(gib: float, fitting: int, horizon: int, limits: Limits) -> None:
    """Refuses a computation that needs more memory than the limit.

    Raises:
        TooMuchError: as above; `fitting` is named as the largest horizon that fits.
    """
    if gib > limits.gib:
        raise too_much(horizon, fitting, limits, f"takes about {gib:.3g} GiB")


def watched(horizon: int, steps: int, gib: float, limits: Limits, report: Progress) -> Progress:
    """A function to call with the share done: it refuses what turns out to take too long.

    The first moments of a computation are its own trial: from the share that they did follows the
    time of the whole. Refusals come in these moments only, so none costs much. No share is exact,
    so trials are made again as time goes by. A busy machine stalls for moments, so early on it
    takes two trials in a row to refuse.

    Args:
        horizon: that was asked for.
        steps: how many actions are gone through for it.
        gib: memory foreseen.
        limits: of time.
        report: called with every share.

    Returns:
        The function; it raises a `TooMuchError`.
    """
    began = time.monotonic()
    next_trial, doubted = min(_TRIAL, limits.seconds / 10), False

    def watch(share: float) -> None:
        nonlocal next_trial, doubted
        report(share)
        elapsed = time.monotonic() - began
        if not 0 < share < 1 or not next_trial <= elapsed < _STARTED:
            return
        next_trial = 2 * elapsed
        seconds = elapsed / share
        fits = seconds <= limits.seconds
        if not fits and (doubted or elapsed >= _STALL):
            fitting = min(int(steps * limits.seconds / seconds), horizon - 1)
            raise too_much(horizon, fitting, limits, takes(gib, seconds), estimated=True)
        doubted = not fits

    return watch


@dataclass
class Clock:
    """The cost of a computation so far, which refuses what is going to exceed the limits."""

    horizon: int
    limits: Limits

    def __post_init__(self) -> None:
        self.began = self.step_began = time.monotonic()

    def begin(self) -> None:
        """A step begins."""
        self.step_began = time.monotonic()

    def check(self, share: float, step: int) -> None:
        """Refuses a step that is going to take too long, given the share of it that is done."""
        now = time.monotonic()
        in_step = now - self.step_began
        if in_step < min(_TRIAL, self.limits.seconds):
            return
        seconds = self.step_began - self.began + in_step / share
        if seconds > self.limits.seconds:
            cost = f"takes about {seconds:.3g} s"
            raise too_much(self.horizon, step, self.limits, cost, estimated=True)

    def check_now(self, step: int) -> None:
        """Refuses to go on after the limit, whatever is left; so many steps are done."""
        elapsed = time.monotonic() - self.began
        if elapsed > self.limits.seconds:
            raise too_much(
                self.horizon, step, self.limits, f"takes more than {elapsed:.3g} s", estimated=True
            )

    def check_all(self, share: float) -> None:
        """The same of all states, given the share of them that is done."""
        elapsed = time.monotonic() - self.began
        if elapsed >= min(_TRIAL, self.limits.seconds) and elapsed / share > self.limits.seconds:
            cost = f"takes about {elapsed / share:.3g} s"
            raise too_much(self.horizon, self.horizon - 1, self.limits, cost, estimated=True)

    def check_memory(self, held: float, step: int) -> None:
        """Refuses a step that needs more bytes than the limit."""
        gib = held / 2**30
        if gib > self.limits.gib:
            raise too_much(self.horizon, step, self.limits)
