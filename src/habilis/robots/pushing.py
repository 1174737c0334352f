"""A hand that pushes a puck, as a simulator for estimators."""

from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from jaxtyping import Float64

from habilis.checks import is_number
from habilis.estimators.protocol import Random
from habilis.estimators.simulators.mujoco import MujocoSimulator, imported
from habilis.robots.tools import PUCK, with_tool
from habilis.worlds.world import NO_TOOL

if TYPE_CHECKING:
    from mujoco import MjModel  # pyright: ignore[reportAttributeAccessIssue]

_MOVE, _REST = 0.1, 0.0  # seconds, of models that do not say
_CELLS = 20  # of the puck along the longer side of where it may be, of models that do not say
_GRAIN = 50  # of these in a cell


class PushingSimulator:
    """A MuJoCo model of a hand, its tool and a puck as a simulator.

    An action holds one of the controls at its lowest or highest value for `move` seconds, or none;
    then all are 0 for `rest` seconds. What a model does not say with
    `<custom><numeric name="move" data="0.1"/></custom>` is 0.1 and 0.

    States are positions and velocities, rounded to a fiftieth of `resolution`: so fine a reading
    changes nothing that the sensor distinguishes, and sequences that lead to the same place lead
    to the same state, which a search then needs to visit only once.

    Attributes:
        model: the `mujoco.MjModel` with this tool.
        tool: what is in the hand.
        actions: float[2 k + 1, k], none, then each control at its highest and its lowest value.
        names: entries of the state by the joints' names, and "puck", its two positions.
        puck: the indices of the puck's two positions.
        low, high: float[2], the range of the puck's joints, in which it may be put.
        resolution: the size of a cell of the puck's position; a twentieth of the longer range where
            the model has no `<numeric name="resolution"/>`.
        grain: what states are rounded to.
        noise: how many standard normal numbers a step draws: one a control, or 0.

    Example:
        >>> simulator = PushingSimulator("reach.xml", "hook")
        >>> simulator.actions.tolist()
        [[0.0, 0.0], [1.0, 0.0], [-1.0, 0.0], [0.0, 1.0], [0.0, -1.0]]
        >>> start = simulator.placed([[0.2, 0.8]])
        >>> simulator.step(start, simulator.actions[1:2])[0, :4]
        array([0.1, 0. , 0.2, 0.8])
    """

    in_jax = False

    def __init__(
        self,
        model: str | Path,
        tool: str = NO_TOOL,
        *,
        noise: float = 0.0,
        grain: float | None = None,
        threads: int | None = None,
    ):
        """
        Args:
            model: the path of an XML file, its text, or "reach.xml"; see `habilis.robots.tools`.
            tool: one that it has, or "none".
            noise: the standard deviation of the Gaussian noise added to each control that an
                action holds, as a share of half the control's range, which it may exceed.
            grain: what states are rounded to, 0 for not at all; by default a fiftieth of
                `resolution`, and 0 with noise.
            threads: as in `MujocoSimulator`.

        Raises:
            ValueError: MuJoCo cannot read the model, or it is no hand that pushes a puck.
            MissingExtraError: MuJoCo is not installed.
        """
        self.model: MjModel = with_tool(model, tool)
        self.tool = tool
        self._inside = MujocoSimulator(self.model, threads=threads)
        self.puck, self.low, self.high = _place(self.model)
        limited = self.model.actuator_ctrllimited.astype(bool)
        if not limited.all():
            raise ValueError("an actuator has no ctrlrange; give each of the hand's one")
        low, high = self.model.actuator_ctrlrange.T
        self.actions = _axes(low, high)
        self._deviation = _deviation(noise) * (high - low) / 2
        self.noise = self.model.nu if noise else 0
        if noise:  # which goes both ways, also where an action is at the end of the range
            clamp = imported().mjtDisableBit.mjDSBL_CLAMPCTRL
            self.model.opt.disableflags |= int(clamp)
        self.resolution = _numeric(
            self.model, "resolution", float((self.high - self.low).max()) / _CELLS
        )
        default = 0.0 if noise else self.resolution / _GRAIN
        self.grain = default if grain is None else _deviation(grain, "grain")
        step = self.model.opt.timestep
        self._moving = max(1, round(_numeric(self.model, "move", _MOVE) / step))
        self._resting = round(_numeric(self.model, "rest", _REST) / step)
        self.names = {**self._inside.names, "puck": self.puck.tolist()}

    @property
    def is_stochastic(self) -> bool:
        """Whether controls are noisy."""
        return self.noise > 0

    @property
    def initial(self) -> Float64[np.ndarray, "d"]:
        """float64[d], the state in which the model begins."""
        return self._inside.initial

    def placed(self, positions: Any) -> Float64[np.ndarray, "n d"]:
        """The states in which all is as at first, and the puck elsewhere.

        Args:
            positions: float[n, 2], of the puck's two joints.

        Returns:
            One state a row.
        """
        given = np.asarray(positions, np.float64)
        states = np.tile(self.initial, (len(given), 1))
        states[:, self.puck] = given
        return states

    def step(
        self,
        states: Float64[np.ndarray, "n d"],
        actions: Float64[np.ndarray, "n k"],
        key: Random = None,
    ) -> Float64[np.ndarray, "n d"]:
        """One action of many states at once.

        Args:
            states: one a row.
            actions: controls, one for each.
            key: a NumPy generator; has no part in it without noise.

        Returns:
            The next states.
        """
        drawn = key.standard_normal(actions.shape) if self.noise else None
        return self.transition(states, actions, drawn)

    def transition(
        self, states: Float64[np.ndarray, "n d"], actions: Float64[np.ndarray, "n k"], noise: Any
    ) -> Float64[np.ndarray, "n d"]:
        """One action with given noise.

        Args:
            states: one a row.
            actions: controls, one for each.
            noise: float[n, k], standard normal; `None` without.

        Returns:
            The next states.
        """
        controls = actions if noise is None else actions + self._deviation * noise
        moved = self._inside.rollout(states, self._held(controls))
        return moved if not self.grain else np.round(moved / self.grain) * self.grain + 0.0

    def rollout(
        self, states: Float64[np.ndarray, "n d"], sequences: Float64[np.ndarray, "n h k"]
    ) -> Float64[np.ndarray, "n d"]:
        """The states that sequences of actions lead to.

        Args:
            states: one a row.
            sequences: one for each.

        Returns:
            The last states.
        """
        for step in range(sequences.shape[1]):
            states = self.transition(states, sequences[:, step], None)
        return states

    def motion(
        self, state: Float64[np.ndarray, "d"], action: Float64[np.ndarray, "k"]
    ) -> Float64[np.ndarray, "t d"]:
        """All states on the way of one action, one for each of MuJoCo's steps.

        Args:
            state: where it begins.
            action: controls.

        Returns:
            One state a row; the last is that of `step`, not rounded.
        """
        found = []
        for controls in self._held(action[None])[0]:
            state = self._inside.step(state[None], controls[None])[0]
            found.append(state)
        return np.stack(found)

    def _held(self, controls: Float64[np.ndarray, "n k"]) -> Float64[np.ndarray, "n t k"]:
        """The controls of MuJoCo's steps of an action."""
        moving = np.repeat(controls[:, None], self._moving, axis=1)
        still = np.zeros((len(controls), self._resting, controls.shape[1]))
        return np.concatenate([moving, still], axis=1)


def _place(model: Any) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Where the puck's positions are in the state, and their ranges."""
    slide = int(imported().mjtJoint.mjJNT_SLIDE)
    body = model.body(PUCK)
    joints = [model.joint(int(body.jntadr[0]) + index) for index in range(int(body.jntnum[0]))]
    fits = len(joints) == 2 and all(int(joint.type[0]) == slide for joint in joints)
    if not fits or not all(model.jnt_limited[joint.id] for joint in joints):
        raise ValueError(
            "the body 'puck' needs two slide joints, each with a range, and no other joint: the "
            "puck is put within these ranges"
        )
    ranges = np.array([joint.range for joint in joints])
    return np.array([int(joint.qposadr[0]) for joint in joints]), ranges[:, 0], ranges[:, 1]


def _axes(
    low: Float64[np.ndarray, "k"], high: Float64[np.ndarray, "k"]
) -> Float64[np.ndarray, "m k"]:
    found = [np.zeros(len(low))]
    for index in range(len(low)):
        for end in (high, low):
            found.append(np.where(np.arange(len(low)) == index, end, 0.0))
    return np.stack(found)


def _numeric(model: Any, name: str, default: float) -> float:
    """A number that a model says of itself."""
    known = [model.numeric(index).name for index in range(model.nnumeric)]
    value = float(model.numeric(name).data[0]) if name in known else default
    if not 0 <= value < np.inf or (value == 0 and name != "rest"):
        raise ValueError(f"<numeric name={name!r}> is {value:g}; give a number above 0")
    return value


def _deviation(value: float, name: str = "noise") -> float:
    if not is_number(value) or not 0 <= value < np.inf:
        raise ValueError(f"{name} is {value!r}; give 0 or more")
    return float(value)
