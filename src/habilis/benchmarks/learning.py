"""Training: environment steps a second, learning included, and where the time goes."""

import time
from dataclasses import replace
from functools import partial
from typing import Any

import jax
import jax.numpy as jnp
from jaxtyping import Array, Float

from habilis.benchmarks import Result, times
from habilis.benchmarks.apart import measured_apart
from habilis.benchmarks.plain_jax import make_train
from habilis.learning.algorithms import a2c
from habilis.learning.algorithms.ppo import PPO
from habilis.learning.batches import LANES
from habilis.learning.config import Config
from habilis.learning.jobs import Job
from habilis.learning.lanes import Lane, Settings, advance
from habilis.learning.rollout import Context, EnvState, rollout
from habilis.learning.runner import train
from habilis.worlds.world import load_world

RUNS, UPDATES = 10, 250
A2C = a2c.A2C()
CONFIG = Config(world="corridor", algorithm=A2C, runs=RUNS, episodes=1_000_000)
STEPS = RUNS * UPDATES * A2C.envs * A2C.rollout
"""Environment steps of one call of a compiled loop: ten runs side by side."""

ON = f"corridor, {RUNS} runs x {A2C.envs} environments x {A2C.rollout} steps, MLP 64-64"


def results() -> list[Result]:
    rate = steps_a_second()
    return [
        *measured_apart(__name__, "on_one_processor"),
        *measured_apart(__name__, "learners"),
        *measured_apart(__name__, "first_call", JAX_ENABLE_COMPILATION_CACHE="false"),
        Result("training, all processors", rate / 1e6, "M steps/s", f"{ON}; all of train()"),
    ]


def steps_a_second(runs: int = RUNS, lanes: int | None = None, steps: int = 1_000_000) -> float:
    """Of `train` on all processors, bookkeeping included; of so many steps a run."""
    rates: list[float] = []
    undecided = CONFIG.changed(entropy=9.0, runs=runs)  # no run converges and leaves the others
    for each in (20_000, steps):  # the first call compiles
        train(
            replace(undecided, steps=each),
            lambda progress: rates.append(progress.steps_per_second),
            lanes=lanes,
        )
    return rates[-1]


def first_call() -> list[Result]:
    """How long `train` takes to come back with next to nothing learned."""
    began = time.perf_counter()
    train(replace(CONFIG, steps=20_000))
    seconds = time.perf_counter() - began
    return [Result("training, first call", seconds, "s", "one processor, nothing compiled before")]


def on_one_processor() -> list[Result]:
    """Ours beside a plain loop, and what ours spends its time on."""
    ours = Loop.of(CONFIG)
    keys = jax.random.split(jax.random.key(0), RUNS)
    plain = jax.jit(jax.vmap(make_train(load_world("corridor"), A2C, UPDATES)))
    square = jnp.ones((512, 512), jnp.float32)
    product = jax.jit(lambda a, b: a @ b)
    seconds = times(
        {
            "ours": ours.train,
            "acting": ours.act,
            "drawing": ours.draw,
            "plain": lambda: jax.block_until_ready(plain(keys)),
            "product": lambda: jax.block_until_ready(product(square, square)),
        }
    )
    rate, peak = STEPS / seconds["ours"], 2 * 512**3 / seconds["product"]
    flops = flops_a_step(ours.lanes.train_state.parameters)
    share = {name: seconds[name] / seconds["ours"] for name in ("acting", "drawing")}
    rest = 1 - share["acting"] - share["drawing"]
    return [
        Result.of("training, one processor", rate / 1e6, "M steps/s", ON),
        Result.of(
            "plain JAX loop / ours", seconds["plain"] / seconds["ours"], "x", "one processor"
        ),
        Result.of(
            "matrix products at their peak", peak / 1e9, "GFLOP/s", "512 x 512, one processor"
        ),
        Result.of("training / that peak", rate * flops / peak, "", f"{flops:,} FLOP a step"),
        Result.of("acting / training", share["acting"], "", "network, draws of actions, look-ups"),
        Result.of("drawing numbers / training", share["drawing"], "", "one uniform number a step"),
        Result.of("learning / training", rest, "", "the rest: gradient, optimiser"),
    ]


def learners() -> list[Result]:
    """PPO and the intrinsic rewards beside plain A2C, each in its compiled loop."""
    plain, bonus = CONFIG.changed(runs=LANES), {"runs": LANES, "beta": 0.05}
    configs = {
        "A2C": plain,
        "PPO": Config(world="corridor", algorithm=PPO(), runs=LANES, episodes=1_000_000),
        "A2C with counts": CONFIG.changed(intrinsic="count", **bonus),
        "A2C with network distillation": CONFIG.changed(intrinsic="rnd", **bonus),
        "A2C with TOE": CONFIG.changed(intrinsic="object", horizon=6, **bonus),
        "A2C with effective empowerment": CONFIG.changed(
            intrinsic="effective:object", horizon=0, **bonus
        ),
    }
    loops = {name: Loop.of(config) for name, config in configs.items()}
    seconds = times({name: loop.train for name, loop in loops.items()})
    rate = {name: loops[name].steps / seconds[name] / 1e6 for name in loops}
    on = f"corridor, {LANES} runs, one processor"
    speeds = [Result.of(f"{name}, one processor", rate[name], "M steps/s", on) for name in loops]
    return speeds + [
        Result.of(f"plain A2C / {name}", rate["A2C"] / rate[name], "x", "steps a second")
        for name in list(loops)[1:]
    ]


class Loop:
    """The compiled loop with what goes into it, and parts of it alone."""

    def __init__(self, job: Job, settings: Settings, lanes: Lane) -> None:
        # As many steps for every algorithm.
        updates = UPDATES * A2C.envs * A2C.rollout // (job.program.steps // job.program.updates)
        self.dynamics, self.program = job.dynamics[0], replace(job.program, updates=updates)
        self.settings, self.lanes = settings, lanes

    @property
    def steps(self) -> int:
        """Environment steps of one call of `train`."""
        return len(self.lanes.updates) * self.program.steps

    @classmethod
    def of(cls, config: Config) -> "Loop":
        job = Job.of(0, config)
        return cls(
            job,
            _stacked([job.settings] * config.runs),
            _stacked([job.start(run) for run in range(config.runs)]),
        )

    def train(self) -> None:
        self.lanes, _ = jax.block_until_ready(
            advance(self.dynamics, self.settings, self.lanes, self.program)
        )

    def draw(self) -> None:
        jax.block_until_ready(_draws(jax.random.key(0)))

    def act(self) -> None:
        """As many rollouts as `train` makes, without learning from them."""
        train_states, env_states = self.lanes.train_state, self.lanes.env_state
        draws = jnp.broadcast_to(jnp.float32(0.5), (RUNS, UPDATES, A2C.rollout, A2C.envs))
        jax.block_until_ready(self._act(train_states, env_states, draws))

    @partial(jax.jit, static_argnums=0)
    def _act(
        self, train_states: Any, env_states: EnvState, draws: Float[Array, "lanes updates T E"]
    ):
        def one_lane(train_state, env_state, draws):
            context: Any = Context(self.dynamics, jnp.float32(0), jax.random.key(0), jnp.abs)
            act = partial(A2C.act, context, train_state)
            limit = jnp.float32(CONFIG.episode_limit)

            def update(env_state, draws):
                env_state, trajectory = rollout(self.dynamics, act, env_state, limit, draws)
                return env_state, trajectory.transition.sum()

            return jax.lax.scan(update, env_state, draws)

        return jax.vmap(one_lane)(train_states, env_states, draws)


@jax.jit
def _draws(key: Array) -> Float[Array, "lanes updates T E"]:
    keys = jax.random.split(key, RUNS)
    shape = (UPDATES, A2C.rollout, A2C.envs)
    return jax.vmap(lambda k: jax.random.uniform(k, shape))(keys)


def flops_a_step(network: Any) -> int:
    """Of the matrix products: one forward, two backward; looked-up rows have none."""
    weights = sum(weight[0].size for weight, _ in network.layers)
    return 3 * 2 * int(weights)


def _stacked(trees: list[Any]) -> Any:
    return jax.tree.map(lambda *leaves: jnp.stack(leaves), *trees)
