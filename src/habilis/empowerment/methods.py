"""Methods: how a capacity is found, and what finding it may cost."""

from collections.abc import Iterable
from dataclasses import KW_ONLY, dataclass
from typing import Any

from habilis.channels.capacity import checked_tolerance
from habilis.empowerment.arguments import at_least_one, positive, whole_number
from habilis.empowerment.limits import MAX_GIB, MAX_SECONDS, Limits


@dataclass(frozen=True)
class Exact:
    """Every sequence of actions counts, and the value is certified.

        E_h(s) = max over p(a_1 ... a_h) of I(A_1 ... A_h; O_h | s)

    Where nothing is noisy this is a count, and its gap is 0. Elsewhere the channel's capacity is
    found to within `tolerance` (see `capacity`).

    Attributes:
        tolerance: the gap at which to stop where the channel is noisy, above 0, in the unit of the
            values.
        max_gib: memory in GiB that it may take besides the table, foreseen before the start.
        max_seconds: time in seconds that it may take, by an estimate made before the start: of
            noisy channels from a few states, of counting from its first moments. A fixed point or
            a period of what can be reached, which ends long horizons early, is part of it.
        threads: how many work side by side; the values are the same for any number. By default
            as many as there are processors; one where there is little to do, or where channels
            are noisy and have several hundred observations, because there the linear algebra uses
            the processors by itself.

    Raises:
        ValueError: a setting is out of its range.

    Example:
        >>> from habilis import TabularMDP, empowerment
        >>> noisy = TabularMDP.deterministic([[0, 1], [1, 0]]).slippery(0.2)
        >>> bits, gap = empowerment(noisy, 3, method=Exact(tolerance=1e-9), return_gap=True)
        >>> bits.round(3), bool(gap.max() <= 1e-9)
        (array([0.198, 0.198]), True)
    """

    tolerance: float = 1e-6
    max_gib: float = MAX_GIB
    max_seconds: float = MAX_SECONDS
    threads: int | None = None

    def __post_init__(self) -> None:
        _check_settings(self)

    @property
    def limits(self) -> Limits:
        """The limits on the cost of the computation."""
        otherwise = "ask for a lower bound with method=hb.Sampled()"
        return Limits(self.max_gib, self.max_seconds, otherwise)


@dataclass(frozen=True)
class Sampled:
    """Only N sequences of actions are tried, so that the value is a lower bound.

    From each state s they are drawn at random, and the value is the capacity of the channel whose
    inputs they are,

        E_h(s) >= max over p(i) of I(I; O_h | s, a^(I)),   a^(1), ..., a^(N) drawn

    where nothing is noisy, log2 of the number of observations that they lead to. Draws are
    independent, and each action uniform among those that are surely available; sequences that end
    before h actions are left out. The gap reaches up to what no sequences could exceed: the least
    of log2 of the number of possible observations and h log2 of the number of actions.

    Attributes:
        samples: N, how many sequences are drawn for each state, from 1 up.
        seed: of the draws, from 0 up. A state's sequences are the same whichever others are asked
            about.
        tolerance, max_gib, max_seconds, threads: as in `Exact`, by name.

    Raises:
        ValueError: a setting is out of its range.

    Example:
        >>> from habilis import TabularMDP, empowerment
        >>> ring = TabularMDP.deterministic([[(s - 1) % 9, (s + 1) % 9] for s in range(9)])
        >>> few = empowerment(ring, 6, method=Sampled(samples=3, seed=0))
        >>> bool((few <= empowerment(ring, 6)).all())
        True
    """

    samples: int = 1000
    seed: int = 0
    _: KW_ONLY
    tolerance: float = 1e-6
    max_gib: float = MAX_GIB
    max_seconds: float = MAX_SECONDS
    threads: int | None = None

    def __post_init__(self) -> None:
        _set(self, "samples", at_least_one("samples", self.samples))
        _set(self, "seed", whole_number("seed", self.seed))
        _check_settings(self)

    @property
    def limits(self) -> Limits:
        """The limits on the cost of the computation."""
        return Limits(self.max_gib, self.max_seconds, "draw fewer samples")


Method = Exact | Sampled


def checked_method(method: Any, among: Iterable[type] = (Exact, Sampled)) -> Any:
    """`method` if it is one of these, else a ValueError."""
    kinds = tuple(among)
    if not isinstance(method, kinds):
        if isinstance(method, type):
            name = method.__name__
            raise ValueError(f"method is the class {name}; use hb.{name}(), with its settings")
        known = " or ".join(f"hb.{kind.__name__}()" for kind in kinds)
        others = ", or of simulators an estimator, as hb.Counting(0.1)" * (Sampled in kinds)
        raise ValueError(f"method is {method!r}; use {known}{others}")
    return method


def bounds_of(method: Method) -> str:
    """How titles begin: "lower bounds on " where values are sampled."""
    return "lower bounds on " if isinstance(method, Sampled) else ""


def _check_settings(method: Method) -> None:
    """Refuses settings out of range; numbers of NumPy become Python's."""
    _set(method, "tolerance", checked_tolerance(method.tolerance))
    _set(method, "max_gib", positive("max_gib", method.max_gib))
    _set(method, "max_seconds", positive("max_seconds", method.max_seconds))
    if method.threads is not None:
        _set(method, "threads", at_least_one("threads", method.threads))


def _set(method: Method, name: str, value: float) -> None:
    object.__setattr__(method, name, value)  # they are frozen
