"""PPO in the style of PureJaxRL: agent, environments and learning in one compiled program.

    pip install ".[learn,gymnasium]" gymnax six
    python purejaxrl_ppo.py --world corridor --horizon 6 --beta 0.07

It prints the mean length of the episodes that ended in each tenth of the training.
"""

import argparse
from typing import Any, NamedTuple

import flax.linen as nn
import jax
import jax.numpy as jnp
import numpy as np
import optax
from flax.training.train_state import TrainState
from gymnax.wrappers import FlattenObservationWrapper, LogWrapper

from habilis.envs import FunctionalEnv

ENVS, STEPS, EPOCHS, MINIBATCHES = 16, 32, 4, 4
GAMMA, LAMBDA, CLIP, ENTROPY, RATE = 0.95, 0.95, 0.2, 0.01, 3e-3


class ActorCritic(nn.Module):
    actions: int

    @nn.compact
    def __call__(self, x: jax.Array) -> tuple[jax.Array, jax.Array]:
        x = x.astype(jnp.float32)
        actor = nn.Dense(self.actions, kernel_init=nn.initializers.orthogonal(0.01))(
            nn.tanh(nn.Dense(64)(x))
        )
        critic = nn.Dense(1)(nn.tanh(nn.Dense(64)(x)))
        return actor, critic.squeeze(-1)


class Transition(NamedTuple):
    obs: jax.Array
    action: jax.Array
    value: jax.Array
    log_prob: jax.Array
    reward: jax.Array
    terminated: jax.Array
    truncated: jax.Array
    final_value: jax.Array
    info: dict[str, jax.Array]


def make_train(env: Any, params: Any, updates: int) -> Any:
    """A function from a key to the infos of all steps [updates, STEPS, ENVS], and the losses."""
    network = ActorCritic(env.action_space(params).n)
    reset = jax.vmap(env.reset, in_axes=(0, None))
    step_env = jax.vmap(env.step, in_axes=(0, 0, 0, None))

    def log_prob(logits: jax.Array, action: jax.Array) -> jax.Array:
        return jnp.take_along_axis(jax.nn.log_softmax(logits), action[..., None], -1)[..., 0]

    def act(carry: Any, _: None) -> tuple[Any, Transition]:
        train, states, obs, key = carry
        key, act_key, step_key = jax.random.split(key, 3)
        logits, value = network.apply(train.params, obs)
        action = jax.random.categorical(act_key, logits)
        after, states, reward, terminated, truncated, info = step_env(
            jax.random.split(step_key, ENVS), states, action, params
        )
        final = network.apply(train.params, info["final_observation"])[1]
        kept = {name: info[name] for name in info if name.startswith("returned")}
        transition = Transition(
            *(obs, action, value, log_prob(logits, action), reward),
            *(terminated, truncated, final, kept),
        )
        return (train, states, after, key), transition

    def advantages(passed: Transition) -> jax.Array:
        def back(running: jax.Array, t: Transition) -> tuple[jax.Array, jax.Array]:
            delta = t.reward + GAMMA * t.final_value * ~t.terminated - t.value
            running = delta + GAMMA * LAMBDA * running * ~(t.terminated | t.truncated)
            return running, running

        return jax.lax.scan(back, jnp.zeros(ENVS), passed, reverse=True)[1]

    def loss(weights: Any, batch: tuple[Transition, jax.Array]) -> jax.Array:
        t, advantage = batch
        logits, value = network.apply(weights, t.obs)
        ratio = jnp.exp(log_prob(logits, t.action) - t.log_prob)
        scaled = (advantage - advantage.mean()) / (advantage.std() + 1e-8)
        policy = -jnp.minimum(ratio * scaled, jnp.clip(ratio, 1 - CLIP, 1 + CLIP) * scaled).mean()
        critic = jnp.square(value - t.value - advantage).mean()
        share = jax.nn.softmax(logits)
        entropy = -(share * jax.nn.log_softmax(logits)).sum(-1).mean()
        return policy + 0.5 * critic - ENTROPY * entropy

    def learn(train: TrainState, part: Any) -> tuple[TrainState, jax.Array]:
        value, gradient = jax.value_and_grad(loss)(train.params, part)
        return train.apply_gradients(grads=gradient), value

    def epoch(carry: Any, key: jax.Array) -> tuple[Any, jax.Array]:
        train, batch = carry
        order = jax.random.permutation(key, STEPS * ENVS)

        def parts(x: jax.Array) -> jax.Array:
            flat = x.reshape(STEPS * ENVS, *x.shape[2:])[order]
            return flat.reshape(MINIBATCHES, -1, *flat.shape[1:])

        train, losses = jax.lax.scan(learn, train, jax.tree.map(parts, batch))
        return (train, batch), losses

    def update(carry: Any, _: None) -> tuple[Any, Any]:
        (train, states, obs, key), passed = jax.lax.scan(act, carry, None, STEPS)
        key, *keys = jax.random.split(key, EPOCHS + 1)
        batch = (passed, advantages(passed))
        (train, _), losses = jax.lax.scan(epoch, (train, batch), jnp.stack(keys))
        return (train, states, obs, key), (passed.info, losses)

    def train(key: jax.Array) -> tuple[dict[str, jax.Array], jax.Array]:
        key, init_key, reset_key = jax.random.split(key, 3)
        obs, states = reset(jax.random.split(reset_key, ENVS), params)
        optimizer = optax.chain(optax.clip_by_global_norm(0.5), optax.adam(RATE))
        agent = TrainState.create(
            apply_fn=network.apply, params=network.init(init_key, obs), tx=optimizer
        )
        return jax.lax.scan(update, (agent, states, obs, key), None, updates)[1]

    return train


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__.split("\n")[0], formatter_class=argparse.ArgumentDefaultsHelpFormatter
    )
    parser.add_argument("--world", default="corridor", help="name, path or text of a map")
    parser.add_argument("--max-steps", type=int, default=500, help="time limit of an episode")
    parser.add_argument("--horizon", type=int, default=6, help="horizon of object empowerment")
    parser.add_argument("--beta", type=float, default=0.07, help="its weight, in reward per bit")
    parser.add_argument(
        "--total-timesteps", type=int, default=500_000, help="steps of all environments"
    )
    parser.add_argument("--seed", type=int, default=0, help="random seed")
    args = parser.parse_args()

    env = FunctionalEnv(args.world, observation="onehot", max_steps=args.max_steps)
    env = env.with_empowerment(args.horizon, "object", beta=args.beta)
    env = LogWrapper(FlattenObservationWrapper(env))
    updates = args.total_timesteps // (STEPS * ENVS)
    train = jax.jit(make_train(env, env.default_params, updates))
    infos, losses = train(jax.random.key(args.seed))
    parts = (np.array_split(np.asarray(x), 10) for x in (*_episodes(infos), losses))
    for tenth, (ended, lengths, returns, loss) in enumerate(zip(*parts, strict=True), 1):
        length, worth = (x[ended].mean() if ended.any() else np.nan for x in (lengths, returns))
        steps = tenth * args.total_timesteps // 10
        print(
            f"step={steps} episodes={ended.sum()} length={length:.1f} return={worth:.2f} "
            f"loss={loss.mean():.3f}"
        )


def _episodes(infos: dict[str, jax.Array]) -> list[jax.Array]:
    names = ("returned_episode", "returned_episode_lengths", "returned_episode_returns")
    return [infos[name] for name in names]


if __name__ == "__main__":
    main()
