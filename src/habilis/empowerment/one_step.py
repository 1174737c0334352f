"""One step of any table as sparse matrices, a row for each state and action."""

from typing import TYPE_CHECKING

import numpy as np

from habilis.empowerment.sensors import Sensor, is_by_action, observation_probabilities
from habilis.mdp import TabularMDP
from habilis.mdp_arguments import moves_of as moves_of

if TYPE_CHECKING:
    from scipy.sparse import csr_array


def last_observations(mdp: TabularMDP, sensor: Sensor) -> "csr_array":
    """The probabilities of what is observed after an action in a state, float64[S * A, O]."""
    from scipy.sparse import csr_array, vstack

    seen, moves = observation_probabilities(mdp, sensor), moves_of(mdp.transitions)
    if not is_by_action(sensor):
        return csr_array(moves @ seen)
    states, actions = mdp.states, mdp.action_count
    after = [moves[a::actions] @ seen[a * states : (a + 1) * states] for a in range(actions)]
    by_state = np.arange(states * actions).reshape(actions, states).T.ravel()
    return csr_array(vstack(after, format="csr"))[by_state]
