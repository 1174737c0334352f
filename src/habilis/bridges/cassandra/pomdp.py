"""`load_pomdp`: a file in Cassandra's format as a table, a sensor and a belief."""

from dataclasses import dataclass, replace
from pathlib import Path
from typing import Literal

import numpy as np
from jaxtyping import Float64

from habilis.bridges.cassandra.arrays import observation_probabilities, rewards, transitions
from habilis.bridges.cassandra.parsing import Names, parsed
from habilis.files import shown
from habilis.mdp import TabularMDP
from habilis.mdp_description import contents, described
from habilis.reprs import counted, listed, quietly, short, table_html, unfailing


@dataclass(frozen=True, eq=False)
class POMDP:
    """A partially observable MDP, or an MDP, from a file.

    Attributes:
        mdp: the table. `reward` is the mean over next states and observations (of `values: cost`
            its negative), `start` the most probable state of `belief`; no state is terminal.
            `mdp.state(i)` and `mdp.index(name)` lead to the names of states and back.
        sensor: for `empowerment`: float64[A, S, O], the probability of each observation after an
            action, in the state that it led to; float64[S, O] if the action makes no difference;
            "state" in an MDP.
        belief: float64[S], the distribution over states in which episodes begin.
        discount: of rewards, for each step.
        observations: the names of the observations; none if they are numbered, and in an MDP.
    """

    mdp: TabularMDP
    sensor: Float64[np.ndarray, "*A S O"] | Literal["state"]
    belief: Float64[np.ndarray, "S"]
    discount: float
    observations: tuple[str, ...] = ()

    @unfailing
    def __repr__(self) -> str:
        count = 0 if isinstance(self.sensor, str) else self.sensor.shape[-1]
        return short(
            "POMDP" if count else "MDP",
            *described(self.mdp),
            counted(count, "observation") if count else "",
            f"discount {self.discount:g}",
        )

    @quietly
    def _repr_html_(self) -> str:
        """What there is of it, for notebooks."""
        count = 0 if isinstance(self.sensor, str) else self.sensor.shape[-1]
        names = f": {listed(self.observations)}" if self.observations else ""
        more = {"observations": f"{count}{names}" if count else "the state"}
        more["discount"] = f"{self.discount:g}"
        return table_html("POMDP" if count else "MDP", contents(self.mdp) | more)


@dataclass(frozen=True)
class StateNames:
    """The states of a table as its file calls them."""

    names: Names

    def state(self, index: int) -> str:
        """The name of a state."""
        return self.names.names[index]

    def index(self, state: str) -> int:
        """The state of a name; -1 if there is none."""
        return self.names.numbers.get(state, -1)


def load_pomdp(path: str | Path) -> POMDP:
    """The model in a `.pomdp` or `.mdp` file, in the format of Cassandra's pomdp-solve.

    All of the format is read (https://www.pomdp.org/code/pomdp-file-spec.html): counts or names;
    `T:`, `O:` and `R:` by entries, rows and matrices, with `*`, `uniform`, `identity` and `reset`;
    all forms of `start:`. Later entries override earlier ones. A file without `observations:` is an
    MDP. Distributions may miss 1 by 0.00001, as rounded ones do, and are divided by their sum.

    Args:
        path: of the file.

    Returns:
        The table, with what is observed in it, the initial belief and the discount.

    Raises:
        ValueError: the file cannot be read, or does not follow the format; the message names the
            line and what to do.

    Example:
        >>> from tempfile import mkdtemp
        >>> path = Path(mkdtemp()) / "coin.pomdp"
        >>> _ = path.write_text('''
        ... discount: 0.95
        ... values: reward
        ... states: heads tails
        ... actions: toss look
        ... observations: h t
        ... T: toss uniform
        ... T: look identity
        ... O: toss uniform
        ... O: look
        ... 0.9 0.1
        ... 0.2 0.8
        ... R: look : * : * : * -1
        ... ''')
        >>> model = load_pomdp(path)
        >>> model.mdp.actions, model.sensor.shape, model.mdp.reward.tolist()
        (('toss', 'look'), (2, 2, 2), [[0.0, -1.0], [0.0, -1.0]])
        >>> from habilis.empowerment import empowerment
        >>> empowerment(model.mdp, 1, model.sensor).round(3)
        array([0.148, 0.073])
    """
    if not isinstance(path, str | Path):
        raise ValueError(f"path is {path!r:.80}; give the path of a file")
    name = shown(path) if str(path) else "''"
    try:
        text = Path(path).read_text("utf-8")
    except UnicodeDecodeError:
        raise ValueError(f"{name}: is not a text file; give one in Cassandra's format") from None
    except (OSError, ValueError) as error:
        reason = getattr(error, "strerror", None) or error
        raise ValueError(f"{name}: cannot be read ({reason}); name a .pomdp or .mdp file") from None
    file = parsed(name, text)
    moves = transitions(file)
    seen = None
    if file.observations is not None:
        seen = observation_probabilities(file, file.observations)
    mdp = TabularMDP.stochastic(
        moves, rewards(file, moves, seen), start=int(np.argmax(file.belief))
    )
    mdp = replace(
        mdp,
        actions=file.actions.names,
        model_states=StateNames(file.states) if file.states.names else None,
    )
    names = () if file.observations is None else file.observations.names
    return POMDP(mdp, _sensor(seen), file.belief, file.discount, names)


def _sensor(
    seen: Float64[np.ndarray, "A S O"] | None,
) -> Float64[np.ndarray, "*A S O"] | Literal["state"]:
    if seen is None:
        return "state"
    return seen[0] if (seen == seen[0]).all() else seen
