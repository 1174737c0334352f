"""Tabular Q-learning as in Gymnasium's tutorial, on one of our worlds.

    pip install ".[gymnasium]"
    python q_learning.py --beta 0.1

The observation, the cells of agent, tool and can, is the key of a dictionary of values. It prints
the mean return of recent episodes during learning, and at the end the return of the greedy policy.
"""

import argparse
from collections import defaultdict

import gymnasium
import numpy as np
from gymnasium.wrappers import RecordEpisodeStatistics

import habilis

WORLD = """
########
#AP....#
#..##C.#
#.....G#
########
"""


class QLearningAgent:
    def __init__(
        self,
        env: gymnasium.Env,
        learning_rate: float,
        epsilon_decay: float,
        final_epsilon: float,
        discount_factor: float,
        seed: int,
    ):
        self.env = env
        self.lr = learning_rate
        self.epsilon, self.epsilon_decay, self.final_epsilon = 1.0, epsilon_decay, final_epsilon
        self.discount_factor = discount_factor
        self.random = np.random.default_rng(seed)
        self.q_values: defaultdict = defaultdict(lambda: np.zeros(env.action_space.n))

    def get_action(self, obs: np.ndarray) -> int:
        """Epsilon-greedy action."""
        if self.random.random() < self.epsilon:
            return int(self.random.integers(self.env.action_space.n))
        return self.best_action(obs)

    def best_action(self, obs: np.ndarray) -> int:
        return int(np.argmax(self.q_values[tuple(obs)]))

    def update(
        self, obs: np.ndarray, action: int, reward: float, terminated: bool, next_obs: np.ndarray
    ) -> None:
        """One step towards reward + discount * best value; truncation is not termination."""
        future = 0.0 if terminated else self.q_values[tuple(next_obs)].max()
        value = self.q_values[tuple(obs)]
        value[action] += self.lr * (reward + self.discount_factor * future - value[action])

    def decay_epsilon(self) -> None:
        self.epsilon = max(self.final_epsilon, self.epsilon - self.epsilon_decay)


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__.split("\n")[0], formatter_class=argparse.ArgumentDefaultsHelpFormatter
    )
    parser.add_argument("--world", default=WORLD, help="name, path or text of a map")
    parser.add_argument("--episodes", type=int, default=2_000, help="episodes of training")
    parser.add_argument("--max-steps", type=int, default=200, help="time limit of an episode")
    parser.add_argument("--beta", type=float, default=0.1, help="weight of object empowerment")
    parser.add_argument("--horizon", type=int, default=3, help="horizon of that empowerment")
    parser.add_argument("--seed", type=int, default=0, help="random seed")
    args = parser.parse_args()

    env = gymnasium.make("habilis/World-v0", world=args.world, max_steps=args.max_steps)
    env = RecordEpisodeStatistics(env)  # inside the bonus: the task's own reward
    env = habilis.EmpowermentReward(env, horizon=args.horizon, sensor="object", beta=args.beta)
    agent = QLearningAgent(
        env,
        learning_rate=0.5,
        epsilon_decay=2 / args.episodes,
        final_epsilon=0.05,
        discount_factor=0.99,
        seed=args.seed,
    )

    returns = []
    for episode in range(1, args.episodes + 1):
        obs, info = env.reset(seed=args.seed)
        done = False
        while not done:
            action = agent.get_action(obs)
            next_obs, reward, terminated, truncated, info = env.step(action)
            agent.update(obs, action, reward, terminated, next_obs)
            done = terminated or truncated
            obs = next_obs
        agent.decay_epsilon()
        returns.append(info["episode"]["r"])
        if episode % (args.episodes // 10) == 0:
            print(f"episode={episode} return={np.mean(returns[-100:]):.2f}", flush=True)

    obs, info = env.reset(seed=args.seed)
    done = False
    while not done:
        obs, _, terminated, truncated, info = env.step(agent.best_action(obs))
        done = terminated or truncated
    print(f"greedy return={info['episode']['r']:.0f}")


if __name__ == "__main__":
    main()
