"""The interface of an algorithm."""

from copy import copy
from dataclasses import Field, fields, replace
from typing import TYPE_CHECKING, Any, ClassVar, Protocol, TypeVar, runtime_checkable

if TYPE_CHECKING:  # settings are read and checked where JAX is not installed
    from jaxtyping import Array, Float, Int, PRNGKeyArray

    from habilis.learning.dynamics import Dynamics
    from habilis.learning.rollout import Context, Experience


@runtime_checkable
class Algorithm(Protocol):
    """An algorithm: a frozen dataclass of its settings, with the methods that use them.

    Each setting is made by `habilis.checks.setting`, with its help. A `static` one is part of the
    compiled program. All others are hyperparameters, which may differ from run to run in a batch:
    in `act` and `update` they are arrays, one value for the run at hand (see `bound`).

    Everything in the train state that changes while the agent learns is an array, or a tree of
    arrays; `parameters` of it is what a run keeps.

    Attributes:
        tabular: whether it learns a value for each state, and not a function of observations.
        ignores: fields of `Config` that play no part in it; they are refused if they are set.
        counts_episodes: whether `Context.episodes` is needed.
        envs, rollout: environments of a run, and steps of each between two updates; with a
            rollout of 0, an update follows a whole episode of each.
        discount: gamma.
        reward_scale: factor on the reward that it learns from.
    """

    tabular: ClassVar[bool]
    ignores: ClassVar[tuple[str, ...]]
    __dataclass_fields__: ClassVar[dict[str, Any]]

    @property
    def counts_episodes(self) -> bool:
        """Whether `Context.episodes` is needed."""
        ...

    @property
    def envs(self) -> int:
        """Environments of a run."""
        ...

    @property
    def rollout(self) -> int:
        """Steps of each environment between two updates; 0: a whole episode."""
        ...

    @property
    def discount(self) -> float:
        """Gamma, the discount factor."""
        ...

    @property
    def reward_scale(self) -> float:
        """The factor on the reward that it learns from."""
        ...

    def init(self, dynamics: "Dynamics", rows: int, key: "PRNGKeyArray") -> Any:
        """The train state before the first update.

        Args:
            dynamics: the table.
            rows: how many rows the first weights of a network have.
            key: for the initial weights.

        Returns:
            A named tuple with `parameters`.
        """
        ...

    def act(
        self,
        context: "Context",
        train_state: Any,
        state: "Int[Array, 'E']",
        draw: "Float[Array, 'E']",
    ) -> tuple["Int[Array, 'E']", Any]:
        """Chooses an action for each of E environments.

        Args:
            context: of this update.
            train_state: as `init` or the last `update` left it.
            state: of the environments.
            draw: a number from [0, 1) for each, the only randomness there is.

        Returns:
            The actions, and what `update` has to know of the decision.
        """
        ...

    def update(
        self, context: "Context", train_state: Any, experience: "Experience"
    ) -> tuple[Any, "Float[Array, '']"]:
        """Learns from a rollout.

        Args:
            context: of this update.
            train_state: as `init` or the last `update` left it.
            experience: the rollout of all environments.

        Returns:
            The train state after the update, and the loss.
        """
        ...

    def policy(self, dynamics: "Dynamics", parameters: Any) -> "Float[Array, 'S A']":
        """The policy that was learned, without exploration.

        Args:
            dynamics: the table.
            parameters: of the train state.

        Returns:
            float[S, A], the probability of each action in every state.
        """
        ...

    def values(self, dynamics: "Dynamics", parameters: Any) -> "Float[Array, 'S']":
        """The values that were learned.

        Args:
            dynamics: the table.
            parameters: of the train state.

        Returns:
            float[S], the expected discounted sum of scaled rewards from every state.
        """
        ...


Kind = TypeVar("Kind", bound=Algorithm)


def hyperparams_of(algorithm: Algorithm) -> dict[str, float]:
    """The settings that the compiled program does not depend on, by their names."""
    return {f.name: getattr(algorithm, f.name) for f in _hyperparams(algorithm)}


def static_part(algorithm: Kind) -> Kind:
    """The algorithm with the default of every hyperparameter: what is compiled."""
    return replace(algorithm, **{f.name: f.default for f in _hyperparams(algorithm)})


def bound(algorithm: Kind, hyperparams: dict[str, Any]) -> Kind:
    """The algorithm with the hyperparameters of one run, as arrays of a compiled program."""
    one = copy(algorithm)  # not checked again: the values of arrays are not known yet
    vars(one).update({f.name: hyperparams[f.name] for f in _hyperparams(algorithm)})
    return one


def _hyperparams(algorithm: Algorithm) -> list[Field]:
    return [f for f in fields(algorithm) if not f.metadata["static"]]
