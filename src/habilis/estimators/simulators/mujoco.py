"""MuJoCo models as simulators."""

import os
import sys
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from ctypes.util import find_library
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from jaxtyping import Float64, UInt8

from habilis.checks import is_number
from habilis.empowerment.arguments import at_least_one
from habilis.estimators.actions import ActionBox, checked_actions
from habilis.estimators.protocol import Random, check_length
from habilis.extras import import_from
from habilis.processors import processors

if TYPE_CHECKING:
    from mujoco import MjData, MjModel  # pyright: ignore[reportAttributeAccessIssue]

_LARGEST = 1e10  # beyond, MuJoCo takes a simulation for unstable


class MujocoSimulator:
    """A MuJoCo model as a simulator: a state is positions, velocities and activations.

    Sequences are rolled out by `mujoco.rollout` on all processors; each starts without a warm
    start of the solver, so that values do not depend on what was computed before.

    The observation is the state, then the model's sensors (`<sensor>`) at that state. Names are
    those of the joints, which stand for their positions (as in "slider"), their velocities
    ("slider velocity"), and those of the sensors.

    Attributes:
        model: the `mujoco.MjModel`.
        actions: an `ActionBox` of the controls' ranges, or the set that was given.
        names: entries of the observation by name.
        substeps: how many steps of MuJoCo one action lasts.
        noise: how many standard normal numbers a step draws: one a control, or 0.

    Example:
        >>> xml = '''<mujoco><option gravity="0 0 0"/><worldbody><body><joint name="slider"
        ... type="slide" axis="1 0 0"/><geom size="0.1" mass="1"/></body></worldbody>
        ... <actuator><motor joint="slider" ctrlrange="-1 1"/></actuator></mujoco>'''
        >>> simulator = MujocoSimulator(xml, substeps=50)
        >>> moved = simulator.step(np.zeros((1, 2)), np.ones((1, 1)))
        >>> moved.round(3).tolist(), dict(simulator.names)
        ([[0.005, 0.1]], {'slider': slice(0, 1, None), 'slider velocity': slice(1, 2, None)})
    """

    in_jax = False

    def __init__(
        self,
        model: "str | Path | MjModel",
        *,
        substeps: int = 1,
        actions: Any = None,
        noise: float = 0.0,
        threads: int | None = None,
    ):
        """
        Args:
            model: a `mujoco.MjModel`, the path of an XML file, or its text.
            substeps: how many steps of MuJoCo one action lasts.
            actions: float[m, k], controls to choose from, or an `ActionBox`; by default all within
                the controls' ranges.
            noise: the standard deviation of the Gaussian noise that is added to each control,
                drawn anew for each action.
            threads: how many roll out side by side; by default one a processor. The values are the
                same for any number.

        Raises:
            ValueError: MuJoCo cannot read the model, it has no control, or a number is out of its
                range.
            MissingExtraError: MuJoCo is not installed.
        """
        self.model: MjModel = _model(model)
        if self.model.nu == 0:
            raise ValueError("the MuJoCo model has no actuator, so no action; give it one")
        if not is_number(noise) or not 0 <= noise < np.inf:
            raise ValueError(f"noise is {noise!r}; give a standard deviation, 0 or more")
        self.substeps = at_least_one("substeps", substeps)
        self.actions = _controls(self.model) if actions is None else checked_actions(actions)
        self.noise = self.model.nu if noise else 0
        self._deviation = float(noise)
        self._threads = processors() if threads is None else at_least_one("threads", threads)
        self._spare: list[Any] = []  # MuJoCo's data, which take longer to make than a step
        self._initial, self._places = _layout(self.model)
        self.names: Mapping[str, slice] = _names(self.model, len(self._places))

    @property
    def is_stochastic(self) -> bool:
        """Whether controls are noisy."""
        return self.noise > 0

    @property
    def initial(self) -> Float64[np.ndarray, "d"]:
        """float64[d], the state in which the model begins."""
        return self._initial[self._places]

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
        self,
        states: Float64[np.ndarray, "n d"],
        actions: Float64[np.ndarray, "n k"],
        noise: Any,
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
        return self.rollout(states, controls[:, None])

    def rollout(
        self, states: Float64[np.ndarray, "n d"], sequences: Float64[np.ndarray, "n h k"]
    ) -> Float64[np.ndarray, "n d"]:
        """The states that sequences of controls lead to.

        Args:
            states: one a row.
            sequences: one for each.

        Returns:
            The last states; not finite where MuJoCo finds the simulation unstable.
        """
        if not len(states) or not sequences.shape[1]:
            return states
        controls = np.repeat(sequences, self.substeps, axis=1)
        rolled = self._rolled(states, controls)[0][:, :, self._places]
        largest = np.abs(rolled).max(axis=(1, 2), keepdims=True)
        return np.where(largest[:, 0] <= _LARGEST, rolled[:, -1], np.nan)

    def observe(self, states: Float64[np.ndarray, "n d"]) -> Float64[np.ndarray, "n o"]:
        """The observations of states.

        Args:
            states: one a row.

        Returns:
            The state and the sensors, one a row.
        """
        if not self.model.nsensordata or not len(states):
            return states
        # MuJoCo evaluates sensors before it moves on: those of the first step are the state's own.
        still = np.zeros((len(states), 1, self.model.nu))
        return np.concatenate([states, self._rolled(states, still)[1][:, 0]], axis=1)

    def render(
        self,
        state: Float64[np.ndarray, "d"],
        height: int = 480,
        width: int = 640,
        camera: str | int = -1,
    ) -> UInt8[np.ndarray, "height width 3"]:
        """The picture of a state, without a window.

        Args:
            state: one.
            height: in pixels.
            width: in pixels.
            camera: of the model, by name or number; -1 is the free one.

        Returns:
            Red, green and blue.

        Raises:
            ValueError: there is no library to render with.
        """
        mujoco = imported()
        data = mujoco.MjData(self.model)
        mujoco.mj_setState(self.model, data, state, mujoco.mjtState.mjSTATE_PHYSICS)
        mujoco.mj_forward(self.model, data)
        try:
            renderer = mujoco.Renderer(self.model, height, width)
        except Exception as error:  # whatever the system's OpenGL has to say
            raise ValueError(
                f"MuJoCo cannot render here ({error!s:.80}); install libegl1, and set "
                "MUJOCO_GL=egl before Python starts"
            ) from None
        with renderer:
            renderer.update_scene(data, camera=camera)
            return renderer.render()

    def _rolled(
        self, states: Float64[np.ndarray, "n d"], controls: Float64[np.ndarray, "n t k"]
    ) -> tuple[np.ndarray, np.ndarray]:
        """All states and sensors on the way."""
        mujoco, rollout = imported(), import_from("mujoco.rollout", "robots")
        check_length(states, len(self._places))
        whole = np.repeat(self._initial[None], len(states), axis=0)
        whole[:, self._places] = states
        # Out of the list while in use, in case several threads call this simulator.
        wanted = min(self._threads, len(states))
        data, self._spare = self._spare, []
        data += [mujoco.MjData(self.model) for _ in range(wanted - len(data))]
        rolled = rollout.rollout(self.model, data[:wanted], whole, np.ascontiguousarray(controls))
        self._spare = data
        return rolled


def imported() -> Any:
    """MuJoCo, which decides when it is imported how it renders: without a screen by EGL."""
    with _without_screen():
        return import_from("mujoco", "robots")


@contextmanager
def _without_screen() -> Iterator[None]:
    decided = "mujoco" in sys.modules or {"MUJOCO_GL", "DISPLAY"} & os.environ.keys()
    if decided or sys.platform != "linux" or find_library("EGL") is None:
        yield
        return
    os.environ["MUJOCO_GL"] = "egl"
    try:
        yield
    finally:
        del os.environ["MUJOCO_GL"]


def _model(given: Any) -> Any:
    mujoco = imported()
    if isinstance(given, mujoco.MjModel):
        return given
    text = str(given)
    if not text.lstrip().startswith("<") and not Path(text).is_file():
        raise ValueError(f"{text!r:.60}: no such file; give the path of a MuJoCo file, or its text")
    try:
        if text.lstrip().startswith("<"):
            return mujoco.MjModel.from_xml_string(text)
        return mujoco.MjModel.from_xml_path(text)
    except ValueError as error:
        raise ValueError(
            f"MuJoCo cannot read {text!r:.60}: {' '.join(str(error).split())}"
        ) from None


def _controls(model: "MjModel") -> ActionBox:
    limited = model.actuator_ctrllimited.astype(bool)
    low = np.where(limited, model.actuator_ctrlrange[:, 0], -np.inf)
    return ActionBox(low, np.where(limited, model.actuator_ctrlrange[:, 1], np.inf))


def _layout(model: "MjModel") -> tuple[np.ndarray, np.ndarray]:
    """The state in which a model begins, as rollouts have it, and where ours is in that."""
    mujoco = imported()
    ours, theirs = mujoco.mjtState.mjSTATE_PHYSICS, mujoco.mjtState.mjSTATE_FULLPHYSICS

    def whole(data: "MjData") -> np.ndarray:
        state = np.empty(mujoco.mj_stateSize(model, theirs))
        mujoco.mj_getState(model, data, state, theirs)
        return state

    data = mujoco.MjData(model)
    initial = whole(data)
    size = mujoco.mj_stateSize(model, ours)
    marks = 1000.0 + np.arange(size)
    mujoco.mj_setState(model, data, marks, ours)
    marked = whole(data)
    places = np.array([int(np.flatnonzero(marked == mark)[0]) for mark in marks], np.int64)
    return initial, places


def _names(model: "MjModel", size: int) -> dict[str, slice]:
    """The entries of named joints and sensors."""
    mujoco = imported()
    joints = [model.joint(index) for index in range(model.njnt)]
    widths = {
        int(mujoco.mjtJoint.mjJNT_FREE): (7, 6),
        int(mujoco.mjtJoint.mjJNT_BALL): (4, 3),
    }
    names = {}
    for joint in joints:
        if not joint.name:
            continue
        positions, velocities = widths.get(int(joint.type[0]), (1, 1))
        first, speed = int(joint.qposadr[0]), model.nq + int(joint.dofadr[0])
        names[joint.name] = slice(first, first + positions)
        names[f"{joint.name} velocity"] = slice(speed, speed + velocities)
    for index in range(model.nsensor):
        sensor = model.sensor(index)
        if sensor.name:
            first = size + int(sensor.adr[0])
            names[sensor.name] = slice(first, first + int(sensor.dim[0]))
    return names
