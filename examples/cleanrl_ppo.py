"""Single-file PPO in the style of CleanRL, with empowerment in the reward.

    pip install ".[gymnasium]" torch
    python cleanrl_ppo.py --env-id habilis/Corridor-v0 --horizon 6 --beta 0.07

It prints the mean length and return of the last hundred episodes, twenty times.
"""

import argparse
import random

import gymnasium
import numpy as np
import torch
from gymnasium.wrappers.vector import RecordEpisodeStatistics
from torch import nn
from torch.distributions import Categorical

import habilis


def parse_args() -> argparse.Namespace:
    parser = argparse.ArgumentParser(
        description=__doc__.split("\n")[0], formatter_class=argparse.ArgumentDefaultsHelpFormatter
    )
    say = parser.add_argument
    say("--env-id", default="habilis/Corridor-v0", help="the environment")
    say("--world", default=None, help="name, path or text of a map, for habilis/World-v0")
    say("--max-steps", type=int, default=500, help="steps after which an episode is truncated")
    say(
        "--sensor", default="object", help="sensor of the empowerment: state, object, agent or tool"
    )
    say("--horizon", type=int, default=6, help="horizon of the empowerment")
    say("--beta", type=float, default=0.07, help="its weight, in reward per bit")
    say("--seed", type=int, default=1, help="random seed")
    say("--total-timesteps", type=int, default=100_000, help="steps of all environments")
    say("--num-envs", type=int, default=16, help="environments that step at once")
    say("--num-steps", type=int, default=32, help="steps per environment and update")
    say("--learning-rate", type=float, default=3e-3, help="step size of Adam, annealed to 0")
    say("--gamma", type=float, default=0.95, help="discount")
    say("--gae-lambda", type=float, default=0.95, help="lambda of the advantages")
    say("--num-minibatches", type=int, default=4, help="minibatches per epoch")
    say("--update-epochs", type=int, default=4, help="epochs per update")
    say("--clip-coef", type=float, default=0.2, help="clipping of the policy ratio")
    say("--ent-coef", type=float, default=0.01, help="weight of the entropy")
    say("--vf-coef", type=float, default=0.5, help="weight of the value's loss")
    say("--max-grad-norm", type=float, default=0.5, help="maximum norm of the gradient")
    return parser.parse_args()


def make_envs(args: argparse.Namespace) -> RecordEpisodeStatistics:
    settings = {} if args.world is None else {"world": args.world}
    envs = gymnasium.make_vec(
        *(args.env_id, args.num_envs),
        observation="onehot",
        max_steps=args.max_steps,
        **settings,
    )
    envs = habilis.EmpowermentReward(envs, horizon=args.horizon, sensor=args.sensor, beta=args.beta)
    return RecordEpisodeStatistics(envs)


def layer(inputs: int, outputs: int, gain: float = 2**0.5) -> nn.Linear:
    linear = nn.Linear(inputs, outputs)
    nn.init.orthogonal_(linear.weight, gain)
    nn.init.zeros_(linear.bias)
    return linear


class Agent(nn.Module):
    def __init__(self, envs: gymnasium.vector.VectorEnv):
        super().__init__()
        inputs = int(np.prod(envs.single_observation_space.shape))
        actions = int(envs.single_action_space.n)
        self.actor = nn.Sequential(layer(inputs, 64), nn.Tanh(), layer(64, actions, gain=0.01))
        self.critic = nn.Sequential(layer(inputs, 64), nn.Tanh(), layer(64, 1, gain=1.0))

    def policy(self, obs: torch.Tensor) -> Categorical:
        return Categorical(logits=self.actor(obs))

    def value(self, obs: torch.Tensor) -> torch.Tensor:
        return self.critic(obs).squeeze(-1)


if __name__ == "__main__":
    args = parse_args()
    random.seed(args.seed)
    np.random.seed(args.seed)
    torch.manual_seed(args.seed)
    torch.set_num_threads(1)  # the networks are too small for more

    envs = make_envs(args)
    agent = Agent(envs)
    optimizer = torch.optim.Adam(agent.parameters(), lr=args.learning_rate, eps=1e-5)

    # Rollout storage: T steps of N environments.
    T, N = args.num_steps, args.num_envs
    obs = torch.zeros((T + 1, N, *envs.single_observation_space.shape))
    actions = torch.zeros((T, N), dtype=torch.long)
    logprobs, rewards = torch.zeros((T, N)), torch.zeros((T, N))
    terminated, valid = torch.zeros((T, N)), torch.zeros((T, N), dtype=torch.bool)
    ended = torch.zeros((T, N), dtype=torch.bool)

    first, _ = envs.reset(seed=args.seed)
    next_obs = torch.as_tensor(first, dtype=torch.float32)
    over = torch.zeros(N, dtype=torch.bool)  # the next step only resets
    updates = args.total_timesteps // (T * N)

    for update in range(updates):
        optimizer.param_groups[0]["lr"] = args.learning_rate * (1 - update / updates)

        for t in range(T):
            obs[t], valid[t] = next_obs, ~over
            with torch.no_grad():
                policy = agent.policy(next_obs)
                action = policy.sample()
            actions[t], logprobs[t] = action, policy.log_prob(action)
            seen, reward, terminations, truncations, infos = envs.step(action.numpy())
            next_obs = torch.as_tensor(seen, dtype=torch.float32)
            rewards[t] = torch.as_tensor(reward)
            terminated[t] = torch.as_tensor(terminations)
            over = torch.as_tensor(terminations | truncations)
            ended[t] = over
        obs[T] = next_obs

        # Generalised advantages. In autoreset mode NextStep the observation after an episode's last
        # step is still its own, so a truncated episode bootstraps from its final value.
        with torch.no_grad():
            values = agent.value(obs)
            advantages = torch.zeros((T, N))
            running = torch.zeros(N)
            for t in reversed(range(T)):
                delta = rewards[t] + args.gamma * values[t + 1] * (1 - terminated[t]) - values[t]
                running = delta + args.gamma * args.gae_lambda * running * ~ended[t]
                advantages[t] = running
            returns = advantages + values[:-1]

        # Learn from all steps except resets.
        b_obs, b_actions, b_logprobs = obs[:-1][valid], actions[valid], logprobs[valid]
        b_advantages, b_returns = advantages[valid], returns[valid]
        for _ in range(args.update_epochs):
            for part in torch.randperm(len(b_obs)).chunk(args.num_minibatches):
                policy = agent.policy(b_obs[part])
                ratio = (policy.log_prob(b_actions[part]) - b_logprobs[part]).exp()
                advantage = b_advantages[part]
                advantage = (advantage - advantage.mean()) / (advantage.std() + 1e-8)
                clipped = ratio.clamp(1 - args.clip_coef, 1 + args.clip_coef)
                pg_loss = -torch.min(ratio * advantage, clipped * advantage).mean()
                v_loss = 0.5 * (agent.value(b_obs[part]) - b_returns[part]).square().mean()
                loss = pg_loss + args.vf_coef * v_loss - args.ent_coef * policy.entropy().mean()
                optimizer.zero_grad()
                loss.backward()
                nn.utils.clip_grad_norm_(agent.parameters(), args.max_grad_norm)
                optimizer.step()

        if (update + 1) % max(updates // 20, 1) == 0 and envs.length_queue:
            length, worth = np.mean(envs.length_queue), np.mean(envs.return_queue)
            print(
                f"step={(update + 1) * T * N} episodes={envs.episode_count} "
                f"length={length:.1f} return={worth:.2f} loss={loss.item():.3f}",
                flush=True,
            )
    envs.close()
