"""Two assistants in one corridor: one wants options for itself, the other wants them for a human.

    python assistant.py

Every number is exact. The human walks at random. Each assistant takes the action after which the
3-step empowerment that it cares about is the largest in the mean, and stays where none is better.
"""

import numpy as np

import habilis as hb

CORRIDOR = """
E = agent
##.##
E..A.
"""
HORIZON, STEPS = 3, 20


def main() -> None:
    mdp = hb.tabulate(hb.World.parse(CORRIDOR, "corridor"))
    own = hb.empowerment(mdp, HORIZON, "agent", player="agent")
    human = hb.empowerment(mdp, HORIZON, "agent2", player="agent2")
    # What an action changes, in the mean over what the human does.
    for_itself = mean_after_actions(mdp.of_player("agent"), own) - own[:, None]
    for_human = hb.assistance(mdp, "agent", "agent2", HORIZON, "agent2")
    policies = {"for itself": greedy(for_itself), "for the human": greedy(for_human)}
    print(f"{'the assistant acts':20} its own bits   the human's")
    print(f"{'at the start':20} {own[mdp.start]:12.2f} {human[mdp.start]:13.2f}")
    for name, policy in policies.items():
        belief = after_steps(mdp.of_player("agent2", {"agent": policy}), STEPS)
        print(f"{f'after {STEPS}, {name}':20} {belief @ own:11.2f} {belief @ human:13.2f}")


def mean_after_actions(mdp: hb.TabularMDP, values: np.ndarray) -> np.ndarray:
    """The mean value of the next state, float[S, A]."""
    return np.stack([mdp.transition(a) @ values for a in range(mdp.action_count)], axis=1)


def greedy(values: np.ndarray) -> np.ndarray:
    """The policy of the best action, float[S, A]; of equals the last one, which is to stay."""
    best = np.isclose(values, values.max(axis=1, keepdims=True), atol=1e-6)
    return np.eye(values.shape[1])[values.shape[1] - 1 - best[:, ::-1].argmax(axis=1)]


def after_steps(mdp: hb.TabularMDP, steps: int) -> np.ndarray:
    """The distribution over states after some steps of random actions from the start, float[S]."""
    matrices = [mdp.transition(a) for a in range(mdp.action_count)]
    belief = np.eye(mdp.states)[mdp.start]
    for _ in range(steps):
        belief = np.mean([belief @ matrix for matrix in matrices], axis=0)
    return belief


if __name__ == "__main__":
    main()
