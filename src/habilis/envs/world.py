"""The worlds as Gymnasium environments, one at a time and many at once."""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import gymnasium
import numpy as np
from gymnasium.vector import AutoresetMode
from jaxtyping import Shaped

from habilis.empowerment.api import Options
from habilis.empowerment.old_keywords import OLD_KEYWORDS, with_method
from habilis.envs.observations import Observation, observation
from habilis.envs.rendering import FRAMES_PER_SECOND, MODES, Renderer, Window, check_mode
from habilis.envs.table import MAX_STEPS, TableEnv
from habilis.envs.vector import TableVectorEnv
from habilis.mdp import TabularMDP
from habilis.rewards.cached_tables import kept_empowerment
from habilis.worlds.map_text import AGENT, GOAL, OBJECT
from habilis.worlds.table import tabulate
from habilis.worlds.tools import Tool
from habilis.worlds.world import World, load_world
from habilis.worlds.world_checks import check_one_agent

Measures = Mapping[str, Mapping[str, Any]]
"""By name, the arguments of `habilis.empowerment`: {"toe": {"horizon": 6, "sensor": "object"}}."""


class WorldEnv(TableEnv):
    """A world of agent, tool and can as a Gymnasium environment.

    Actions: `Discrete(8)`, 0 to 3 move the agent north, east, south, west, 4 to 7 put the tool on
    that side of it; without a tool `Discrete(4)`; `Discrete(9)` where 8 puts the tool down. Reward:
    -1 a step, and 0 for the one that brings the can into the goal, which terminates the episode, or
    the last of several objects into its goal. After `max_steps` it is truncated.

    `info` has "state" (the index in `mdp`), "equipped" and "attached" (bool), and the bits of each
    measure that was asked for, by its name.

    Attributes:
        world: the map.
        mdp: its table.
        state: the index of the state that the environment is in.

    Example:
        >>> import gymnasium, habilis
        >>> toe = {"horizon": 3, "sensor": "object"}
        >>> env = gymnasium.make("habilis/Yard-v0", tool="broom", measures={"toe": toe})
        >>> observation, info = env.reset(seed=0)
        >>> observation, info["equipped"], info["toe"]
        (array([20, 30, 83]), True, 0.0)
    """

    metadata = {"render_modes": list(MODES), "render_fps": FRAMES_PER_SECOND}  # noqa: RUF012  # as Gymnasium has it

    def __init__(
        self,
        world: World | str | Path,
        tool: str | Tool | type | None = None,
        max_steps: int = MAX_STEPS,
        observation: str = "factors",
        measures: Measures | None = None,
        slip: float = 0.0,
        render_mode: str | None = None,
    ):
        """
        Args:
            world: a world, a built-in one's name, the path of a map, or the text of one.
            tool: takes the place of the map's own, by its name or itself; `None` keeps that.
            max_steps: the length of an episode, at most.
            observation: "factors", `MultiDiscrete`, the cells of agent, tool and object, each
                `row * columns + column` (of several which is in hand too); "onehot", the same as
                zeros and ones; "grid", uint8 `[channels, rows, columns]`; or "rgb", a picture. See
                `observations.observation`.
            measures: by name, arguments of `habilis.empowerment`, whose bits are in `info`.
            slip: the probability that an action drawn uniformly takes the place of the chosen one.
            render_mode: "ansi", "rgb_array", "human" (a window), or `None`.

        Raises:
            ValueError: no such world, tool, observation, measure or mode, or a number is out of
                its range.
        """
        check_mode(render_mode)
        table = WorldTable.of(world, tool, observation, measures, slip)
        super().__init__(
            table.mdp,
            max_steps,
            observation=table.observation,
            columns=table.columns,
            slip=slip,
        )
        self.world, self.render_mode = table.world, render_mode
        self._renderer = Renderer.of(table.world, table.mdp, render_mode)
        self._window: Window | None = None

    def reset(
        self, *, seed: int | None = None, options: dict[str, Any] | None = None
    ) -> tuple[np.ndarray, dict[str, Any]]:
        begun = super().reset(seed=seed, options=options)
        if self.render_mode == "human":
            self.render()
        return begun

    def step(self, action: Any) -> tuple[np.ndarray, float, bool, bool, dict[str, Any]]:
        stepped = super().step(action)
        if self.render_mode == "human":
            self.render()
        return stepped

    def render(self) -> Any:
        """The state as coloured text, as pixels, or in the window, as `render_mode` has it."""
        if self.render_mode is None:
            gymnasium.logger.warn('render() draws nothing: make it with render_mode="rgb_array"')
            return None
        if self.render_mode == "ansi":
            return self._renderer.text(self.state)
        picture = self._renderer.picture(self.state)
        if self.render_mode == "rgb_array":
            return picture
        if self._window is None:
            self._window = Window(f"habilis: {self.world.name}")
        self._window.show(picture)
        return None

    def close(self) -> None:
        if self._window is not None:
            self._window.close()
            self._window = None


class WorldVectorEnv(TableVectorEnv):
    """Many environments on one world at once; each is a `WorldEnv`.

    Made by `gymnasium.make_vec("habilis/Corridor-v0", num_envs=1024)` too. See `TableVectorEnv` for
    the autoreset modes. `render` is a tuple of one picture (or text) an environment.

    Attributes:
        world: the map.
        mdp: its table.
        state: int64[N], the states that the environments are in.

    Example:
        >>> envs = WorldVectorEnv(num_envs=2, world="corridor", autoreset_mode="SameStep")
        >>> envs.reset(seed=0)[1]["equipped"]
        array([False, False])
    """

    metadata = {"render_modes": ["ansi", "rgb_array"], "render_fps": FRAMES_PER_SECOND}  # noqa: RUF012  # as Gymnasium has it

    def __init__(
        self,
        num_envs: int,
        world: World | str | Path,
        tool: str | Tool | type | None = None,
        max_steps: int = MAX_STEPS,
        observation: str = "factors",
        measures: Measures | None = None,
        slip: float = 0.0,
        render_mode: str | None = None,
        autoreset_mode: AutoresetMode | str = AutoresetMode.NEXT_STEP,
    ):
        """
        Args:
            num_envs: N.
            world, tool, max_steps, observation, measures, slip: as in `WorldEnv`.
            render_mode: "ansi", "rgb_array", or `None`.
            autoreset_mode: Gymnasium's, or its name: "NextStep", "SameStep", "Disabled".

        Raises:
            ValueError: as in `WorldEnv`, or there is no such mode.
        """
        if render_mode == "human":
            raise ValueError('render_mode "human" is for one environment; use "rgb_array"')
        check_mode(render_mode)
        table = WorldTable.of(world, tool, observation, measures, slip)
        super().__init__(
            table.mdp,
            num_envs,
            max_steps,
            autoreset_mode=autoreset_mode,
            observation=table.observation,
            columns=table.columns,
            slip=slip,
        )
        self.world, self.render_mode = table.world, render_mode
        self._renderer = Renderer.of(table.world, table.mdp, render_mode)

    def render(self) -> tuple[Any, ...] | None:
        if self.render_mode is None:
            gymnasium.logger.warn('render() draws nothing: make it with render_mode="rgb_array"')
            return None
        if self.render_mode == "ansi":
            return tuple(self._renderer.text(int(state)) for state in self.state)
        return tuple(self._renderer.picture(self.state))


@dataclass(frozen=True)
class WorldTable:
    """A world with what its environments look up.

    Attributes:
        world: the map.
        mdp: its table.
        observation: of its states.
        columns: by name, the values of every state that `info` has.
    """

    world: World
    mdp: TabularMDP
    observation: Observation
    columns: dict[str, Shaped[np.ndarray, "S"]]

    @classmethod
    def of(
        cls,
        world: World | str | Path,
        tool: str | Tool | type | None,
        shown: str,
        measures: Measures | None,
        slip: float,
    ) -> "WorldTable":
        found = as_world(world)
        found = found if tool is None else found.with_tool(tool)
        mdp = tabulate(found)
        columns: dict[str, np.ndarray] = dict(mdp.flags)
        if not isinstance(measures, Mapping | None):
            raise ValueError(f"measures is {measures!r}; give names with arguments")
        noisy = mdp.slippery(slip) if measures else mdp
        for name, arguments in (measures or {}).items():
            if not isinstance(name, str):
                raise ValueError(f"measures has the name {name!r}; give a string")
            if name in columns or name == "state":
                raise ValueError(f"measure {name!r} is what info has already; give another name")
            _check_measure(name, arguments)
            try:
                columns[name] = kept_empowerment(noisy, **with_method("measures", arguments))
            except ValueError as error:
                raise ValueError(f"measure {name!r}: {error}") from None
        return cls(found, mdp, observation(shown, mdp, found), columns)


def _check_measure(measure: str, arguments: Any) -> None:
    """Refuses arguments that do not make `habilis.empowerment` return a value for every state."""
    named = f"measure {measure!r}"
    example = '{"horizon": 6, "sensor": "object"}'
    known = ("horizon", "sensor", "actions", *Options.__annotations__)
    if not isinstance(arguments, Mapping):
        raise ValueError(
            f"{named} is {arguments!r}; give arguments of habilis.empowerment, as {example}"
        )
    for name in arguments:
        if name in ("states", "return_gap"):
            raise ValueError(f"{named} needs one value for every state; leave out {name}")
        if name not in (*known, *OLD_KEYWORDS):
            raise ValueError(
                f"{named}: argument {name!r} is unknown; use some of {', '.join(known)}"
            )
    if "horizon" not in arguments:
        raise ValueError(f"{named} has no horizon; give one, as {example}")


def as_world(world: World | str | Path) -> World:
    """A world of one agent as it is, by its name or path, or from its text."""
    found = _as_any_world(world)
    check_one_agent(found)
    return found


def _as_any_world(world: World | str | Path) -> World:
    if isinstance(world, World):
        return world
    if isinstance(world, str) and ("\n" in world or {AGENT, OBJECT, GOAL} <= set(world)):
        try:
            return World.parse(world)
        except ValueError:
            if "\n" in world:
                raise
    if not isinstance(world, str | Path):
        raise ValueError(f"world is {world!r}; give a world, its name, a path, or a map's text")
    return load_world(world)
