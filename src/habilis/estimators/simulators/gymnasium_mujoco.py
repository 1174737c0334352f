"""Gymnasium's MuJoCo environments as simulators."""

from typing import Any

import numpy as np

from habilis.estimators.simulators.mujoco import MujocoSimulator, imported
from habilis.extras import import_from

_TRIED = 5  # steps that are compared
_SAME = 1e-6


def gymnasium_simulator(environment: Any, *, actions: Any = None) -> MujocoSimulator:
    """The simulator of one of Gymnasium's MuJoCo environments.

    Sequences are rolled out by MuJoCo itself, with the environment's model and frame skip. First
    some steps are made in the environment too, from states that `set_state` puts it in; it is
    refused if they lead elsewhere, as with wrappers that change actions. Rewards, ends and time
    limits have no part in it. The environment is reset.

    Args:
        environment: such as `gymnasium.make("Pusher-v5")`, or its ID.
        actions: float[m, k], actions to choose from; by default all within the controls' ranges.

    Returns:
        A simulator. States are positions and velocities; names are those of the joints, as in
        "obj_slidex".

    Raises:
        ValueError: it is no MuJoCo environment, or a step leads elsewhere than MuJoCo does.
        MissingExtraError: Gymnasium or MuJoCo is not installed.

    Example:
        >>> simulator = gymnasium_simulator("InvertedPendulum-v5")
        >>> simulator.substeps, sorted(simulator.names)
        (2, ['hinge', 'hinge velocity', 'slider', 'slider velocity'])
    """
    imported()
    gymnasium = import_from("gymnasium", "robots")
    made = gymnasium.make(environment) if isinstance(environment, str) else environment
    inside = made.unwrapped
    for name in ("model", "data", "set_state", "frame_skip"):
        if not hasattr(inside, name):
            raise ValueError(
                f"{type(inside).__name__} is no MuJoCo environment: it has no `{name}`; give one "
                'such as gymnasium.make("Pusher-v5")'
            )
    simulator = MujocoSimulator(inside.model, substeps=int(inside.frame_skip), actions=actions)
    _compare(made, simulator)
    if made is not environment:
        made.close()
    return simulator


def _compare(made: Any, simulator: MujocoSimulator) -> None:
    """Makes a few steps in both, and refuses an environment that goes elsewhere."""
    inside, nq = made.unwrapped, made.unwrapped.model.nq
    if simulator.model.na:
        raise ValueError(
            "the environment's actuators have states of their own, which set_state does not set; "
            "use habilis.estimators.simulators.MujocoSimulator(env.unwrapped.model)"
        )
    generator = np.random.default_rng(0)
    made.reset(seed=0)
    space = made.action_space
    for _ in range(_TRIED):
        state = np.concatenate([inside.data.qpos, inside.data.qvel])
        low, high = (np.nan_to_num(end, posinf=1.0, neginf=-1.0) for end in (space.low, space.high))
        action = generator.uniform(low, high).astype(np.float64)
        inside.set_state(state[:nq].copy(), state[nq:].copy())
        inside.data.qacc_warmstart[:] = 0
        made.step(action.astype(space.dtype))
        theirs = np.concatenate([inside.data.qpos, inside.data.qvel])
        taken = action.astype(space.dtype).astype(np.float64)
        ours = simulator.step(state[None], taken[None])[0]
        apart = float(np.abs(ours - theirs).max())
        if not apart <= _SAME * (1 + float(np.abs(theirs).max())):
            raise ValueError(
                f"a step of {type(inside).__name__} leads {apart:.2g} away from where MuJoCo does "
                "with its model; remove wrappers that change actions, or write a simulator of it"
            )
    made.reset(seed=0)
