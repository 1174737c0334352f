"""The algorithms and their settings, a dataclass each."""

from dataclasses import dataclass

from habilis.checks import (
    above_zero,
    at_least,
    check_types,
    one_of,
    setting,
    share,
    widths,
)

OPTIMIZERS = ("rmsprop", "rmsprop-torch", "adam")
SCHEDULES = ("steps", "episodes")
NETWORKS = ("shared", "separate")
ACTIVATIONS = ("tanh", "relu", "selu", "sigmoid")
INITIALISATIONS = ("lecun", "orthogonal", "pytorch")

_ENVS = "environments that each run steps together"
_ROLLOUT = "steps of each environment between two updates"
_RATE = "step size of the optimiser"
_RATE_END = "step size after learning_rate_steps"
_RATE_STEPS = "environment steps over which the step size changes linearly; 0: it does not"
_RATE_DECAY = "factor on the step size after each learning_rate_every"
_RATE_EVERY = "environment steps after each of which the step size decays; 0: it does not"
_SCHEDULE = (
    'what the schedules of step size and entropy count: environment "steps", or "episodes" that '
    "have ended, before the rollout that is learned from"
)
_OPTIMIZER = (
    "rmsprop (decay 0.99, epsilon 1e-5 in the root), rmsprop-torch (epsilon outside the root, as "
    "PyTorch has it) or adam"
)
_CLIP = "largest norm of a network's gradient, to which it is clipped; 0: it is not"
_ENTROPY = "weight of the policy's entropy (nats) in the loss"
_ENTROPY_END = "weight of the entropy after entropy_steps"
_ENTROPY_STEPS = "environment steps over which that weight changes linearly; 0: it does not"
_ENTROPY_HOLD = "environment steps before it begins to change"
_VALUE = "weight of the value's squared error in the loss"
_DISCOUNT = "discount factor, gamma"
_LAMBDA = "lambda of the generalised advantage; 1: n-step returns"
_NORMALISE = "whether advantages have mean 0 and deviation 1 in each batch"
_UNBIASED = "whether that deviation divides by n - 1 in place of n"
_SCALE = "factor on the reward that the agent learns from (counted returns have none)"
_HIDDEN = "widths of a network's hidden layers"
_NETWORKS = 'one "shared" trunk for policy and value, or "separate" networks'
_ACTIVATION = f"activation of the hidden layers: {', '.join(ACTIVATIONS)}"
_INITIALISATION = (
    "of weights: lecun (normal, the last layer small), orthogonal (with the activation's gain) or "
    "pytorch (weights and biases uniform within 1 / sqrt(inputs), PyTorch's default)"
)


@dataclass(frozen=True)
class A2C:
    """Advantage actor-critic (Mnih et al. 2016), the paper's.

    The defaults are what the calibration of the paper's tables came to (`studies.calibrate`).
    """

    envs: int = setting(16, _ENVS, static=True)
    rollout: int = setting(5, f"{_ROLLOUT}; 0 (of a2c): a whole episode of each", static=True)
    learning_rate: float = setting(1e-3, _RATE)
    learning_rate_end: float = setting(0.0, _RATE_END)
    learning_rate_steps: int = setting(0, _RATE_STEPS)
    learning_rate_decay: float = setting(1.0, _RATE_DECAY)
    learning_rate_every: int = setting(0, _RATE_EVERY)
    optimizer: str = setting("adam", _OPTIMIZER, static=True)
    clip: float = setting(0.5, _CLIP)
    entropy: float = setting(0.02, _ENTROPY)
    entropy_end: float = setting(0.0, _ENTROPY_END)
    entropy_steps: int = setting(2_500_000, _ENTROPY_STEPS)
    entropy_hold: int = setting(2_500_000, _ENTROPY_HOLD)
    schedule: str = setting("steps", _SCHEDULE, static=True)
    value: float = setting(0.5, _VALUE)
    discount: float = setting(0.99, _DISCOUNT)
    gae_lambda: float = setting(1.0, _LAMBDA)
    normalise: bool = setting(False, _NORMALISE, static=True)
    unbiased: bool = setting(False, _UNBIASED, static=True)
    reward_scale: float = setting(0.1, _SCALE)
    hidden: tuple[int, ...] = setting((64, 64), _HIDDEN, static=True)
    networks: str = setting("shared", _NETWORKS, static=True)
    activation: str = setting("tanh", _ACTIVATION, static=True)
    initialisation: str = setting("lecun", _INITIALISATION, static=True)

    def __post_init__(self) -> None:
        _check_network(self)


@dataclass(frozen=True)
class PPO:
    """Proximal policy optimisation with a clipped objective (Schulman et al. 2017)."""

    envs: int = setting(16, _ENVS, static=True)
    rollout: int = setting(32, _ROLLOUT, static=True)
    epochs: int = setting(4, "passes over what a rollout gave", static=True)
    minibatches: int = setting(4, "parts of it, with a gradient step each", static=True)
    learning_rate: float = setting(1e-3, _RATE)
    learning_rate_end: float = setting(0.0, _RATE_END)
    learning_rate_steps: int = setting(0, _RATE_STEPS)
    learning_rate_decay: float = setting(1.0, _RATE_DECAY)
    learning_rate_every: int = setting(0, _RATE_EVERY)
    optimizer: str = setting("adam", _OPTIMIZER, static=True)
    clip: float = setting(0.5, _CLIP)
    clip_range: float = setting(0.2, "how far a probability's ratio to the old one may count")
    entropy: float = setting(0.02, _ENTROPY)
    entropy_end: float = setting(0.0, _ENTROPY_END)
    entropy_steps: int = setting(0, _ENTROPY_STEPS)
    entropy_hold: int = setting(0, _ENTROPY_HOLD)
    schedule: str = setting("steps", _SCHEDULE, static=True)
    value: float = setting(0.5, _VALUE)
    discount: float = setting(0.99, _DISCOUNT)
    gae_lambda: float = setting(0.95, _LAMBDA)
    normalise: bool = setting(False, _NORMALISE, static=True)
    unbiased: bool = setting(False, _UNBIASED, static=True)
    reward_scale: float = setting(0.1, _SCALE)
    hidden: tuple[int, ...] = setting((64, 64), _HIDDEN, static=True)
    networks: str = setting("shared", _NETWORKS, static=True)
    activation: str = setting("tanh", _ACTIVATION, static=True)
    initialisation: str = setting("lecun", _INITIALISATION, static=True)

    def __post_init__(self) -> None:
        _check_network(self)
        at_least(self, rollout=1, epochs=1, minibatches=1)
        above_zero(self, "clip_range")
        if self.envs * self.rollout % self.minibatches:
            raise ValueError(
                f"minibatches is {self.minibatches}; give a divisor of envs * rollout, "
                f"{self.envs * self.rollout}"
            )


@dataclass(frozen=True)
class QLearning:
    """Tabular Q-learning with an epsilon-greedy policy (Watkins 1989)."""

    envs: int = setting(16, _ENVS, static=True)
    rollout: int = setting(5, _ROLLOUT, static=True)
    learning_rate: float = setting(0.5, "share of the error by which a value changes")
    epsilon: float = setting(0.1, "probability of an action at random")
    epsilon_end: float = setting(0.002, "that probability after epsilon_steps")
    epsilon_steps: int = setting(200_000, "environment steps over which it changes; 0: it stays")
    discount: float = setting(0.99, _DISCOUNT)
    reward_scale: float = setting(1.0, _SCALE)

    def __post_init__(self) -> None:
        check_types(self)
        at_least(self, envs=1, rollout=1, epsilon_steps=0)
        above_zero(self, "reward_scale")
        share(self, "learning_rate", "epsilon", "epsilon_end", "discount")


@dataclass(frozen=True)
class SoftValueIteration:
    """Soft value iteration on the known table (Ziebart 2010), a policy that is not learned.

    Q(s, a) = E[r + gamma * V(s')],    V(s) = T * log sum over a of exp(Q(s, a) / T)
    """

    envs: int = setting(16, _ENVS, static=True)
    rollout: int = setting(50, _ROLLOUT, static=True)
    sweeps: int = setting(1, "backups of all states between two rollouts", static=True)
    temperature: float = setting(0.1, "T: the policy is the softmax of Q / T")
    discount: float = setting(0.99, _DISCOUNT)
    reward_scale: float = setting(1.0, _SCALE)

    def __post_init__(self) -> None:
        check_types(self)
        at_least(self, envs=1, rollout=1, sweeps=1)
        above_zero(self, "temperature", "reward_scale")
        share(self, "discount")


Algorithm = A2C | PPO | QLearning | SoftValueIteration

ALGORITHMS: dict[str, type[Algorithm]] = {
    "a2c": A2C,
    "ppo": PPO,
    "q-learning": QLearning,
    "soft-value-iteration": SoftValueIteration,
}


def name_of(algorithm: Algorithm) -> str:
    """As on the command line."""
    return next(name for name, kind in ALGORITHMS.items() if isinstance(algorithm, kind))


def _check_network(algorithm: A2C | PPO) -> None:
    object.__setattr__(algorithm, "hidden", widths(algorithm.hidden))
    check_types(algorithm)
    at_least(algorithm, envs=1, rollout=0, clip=0, entropy=0, entropy_end=0, value=0)
    at_least(algorithm, entropy_steps=0, entropy_hold=0, learning_rate_end=0)
    at_least(algorithm, learning_rate_steps=0, learning_rate_every=0)
    above_zero(algorithm, "learning_rate", "learning_rate_decay", "reward_scale")
    share(algorithm, "discount", "gae_lambda")
    one_of(algorithm, "optimizer", OPTIMIZERS)
    one_of(algorithm, "schedule", SCHEDULES)
    one_of(algorithm, "networks", NETWORKS)
    one_of(algorithm, "activation", ACTIVATIONS)
    one_of(algorithm, "initialisation", INITIALISATIONS)
    if algorithm.unbiased and not algorithm.normalise:
        raise ValueError(
            "unbiased is True and normalise False; turn on normalise, or turn off unbiased"
        )
