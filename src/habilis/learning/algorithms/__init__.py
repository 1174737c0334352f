"""The algorithms, by their names.

Each is one file: its settings, which are options of `habilis train`, and how it acts and learns
(`protocol.Algorithm`). All lists of algorithms are derived from `ALGORITHMS`.
"""

from habilis.learning.algorithms.registry import Algorithms

ALGORITHMS = Algorithms()
for _name, _where, _label in (
    ("a2c", "a2c:A2C", "A2C"),
    ("ppo", "ppo:PPO", "PPO"),
    ("q-learning", "q_learning:QLearning", "Q-learning"),
    (
        "soft-value-iteration",
        "soft_value_iteration:SoftValueIteration",
        "Soft value iteration",
    ),
):
    ALGORITHMS.register(_name, f"{__name__}.{_where}", _label)
