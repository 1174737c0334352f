"""Assistance: how an action of one player changes the empowerment of another."""

from typing import Any, Unpack

import numpy as np
from jaxtyping import Float64

from habilis.empowerment.api import Options, empowerment
from habilis.empowerment.arguments import check_table, chosen_states
from habilis.empowerment.one_step import moves_of
from habilis.empowerment.sensors import Sensor
from habilis.mdp import TabularMDP
from habilis.mdp_players import UNIFORM, joint_actions, table_of_player


def assistance(
    mdp: TabularMDP,
    helper: str,
    helped: str,
    horizon: int,
    sensor: Sensor = "state",
    states: Any = None,
    *,
    acting: Any = UNIFORM,
    others: Any = UNIFORM,
    **options: Unpack[Options],
) -> Float64[np.ndarray, "n P"]:
    """The expected change of one player's empowerment that an action of another causes, in bits.

    With E the empowerment of the helped player over the next h actions,

        A(s, a) = E[E(S') | s, a] - E(s),    a an action of the helper

    where in the step from s to S' all others, the helped player too, act by a policy. Its negative
    is disempowerment. That an assistant maximises the empowerment of another is the idea of
    Guckelsberger, Salge and Colton (2016), Du et al. (2020) and van der Heiden et al. (2022), who
    use several approximations; this one-step difference is our definition.

    Args:
        mdp: a table of several players.
        helper: who acts.
        helped: whose empowerment it is.
        horizon: h, of that empowerment.
        sensor: of that empowerment, as in `empowerment`.
        states: the n states asked about, as indices or as bool[S]; by default all. Few are quick:
            empowerment is then computed of these and their successors alone.
        acting: the policy of all but the helper in the first step, as `others` in
            `TabularMDP.of_player`.
        others: what all but the helped player do in the h steps that are counted, as in
            `empowerment`: "uniform", a policy, "best" or "worst".
        **options: as in `empowerment`.

    Returns:
        float64[n, P], a column for each of the helper's actions; NaN where it is not available.

    Raises:
        ValueError: helper and helped are one, or as in `empowerment` and `TabularMDP.of_player`.

    Example:
        >>> # The keeper holds a gate open (0) or shut (1), and it stays so; the walker passes.
        >>> states = [(place, gate) for place in (0, 1) for gate in (0, 1)]
        >>> table = [
        ...     [2 * (walk and not gate or place) + keep for walk in (0, 1) for keep in (0, 1)]
        ...     for place, gate in states
        ... ]
        >>> mdp = TabularMDP.deterministic(table, players={"walker": 2, "keeper": 2})
        >>> waits = {"walker": [[1, 0]] * 4}
        >>> assistance(mdp, "keeper", "walker", 1, [0, 0, 1, 1], acting=waits)[:2]
        array([[ 0., -1.],
               [ 1.,  0.]])
    """
    if helper == helped:
        raise ValueError(f"helper and helped are both {helper!r}; name two players")
    check_table(mdp)
    joint_actions(mdp, helped)  # says what is wrong with its name
    alone = table_of_player(mdp, helper, acting, "acting")
    starts = chosen_states(mdp, states)
    count = alone.action_count
    moves = moves_of(alone.transitions)[(starts[:, None] * count + np.arange(count)).ravel()]
    needed = np.union1d(starts, moves.indices)
    bits = np.zeros(mdp.states)
    asked: Any = {"player": helped, "others": others, **options}
    bits[needed] = empowerment(mdp, horizon, sensor, states=needed, **asked)
    after = (moves @ bits).reshape(len(starts), count)
    return np.where(alone.available[starts], after - bits[starts, None], np.nan)
