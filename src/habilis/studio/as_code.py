"""The screen's numbers as code: Python, and commands of a shell, that compute the same."""

import shlex
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields
from pathlib import Path
from typing import Any

from habilis.studio.scenes import ELSEWHERE, Scene
from habilis.worlds.placements import Placement
from habilis.worlds.world import NO_TOOL, World

_FILE = "map.txt"
_END = "MAP"  # of the map in a shell
_RUN = "run"  # the folder of a training
_NOT_SETTINGS = ("world", "tool", "algorithm")


@dataclass(frozen=True)
class Written:
    """Code that computes what a view shows.

    Attributes:
        python: a script.
        command: lines for a shell; `None` if no command computes it.
    """

    python: str
    command: str | None


def landscape(scene: Scene, world: World, tools: Sequence[str]) -> Written:
    """The landscape, and the averages of some tools.

    Args:
        scene: the world and the question.
        world: the same as drawn, if the scene's agent uses no tool.
        tools: those whose exact averages are shown.
    """
    bare = not scene.world.tools and bool(world.tools)
    sensor, lines = _sensor(scene)
    python = _opening(world, bare, lines)
    of = scene.measured
    tabulated = bool(lines) or (of.needs_whole and not world.single)
    if tabulated:  # the agent may be where it can never come
        things = {name: at for name, at in scene.placement.items() if name != "agent"}
        python += [f"things = {_literal(things)}"]
        python += ['starts = [{**things, "agent": cell} for cell in world.agent_cells]']
        python += [f"mdp = hb.tabulate(world{_slip(scene)}, starts=starts)", *lines]
    given = of.keywords() + (", mdp=mdp" if tabulated else _slip(scene))
    python += [f"landscape = hb.landscape(world, {_arguments(scene, sensor)}{given})"]
    python += ["print(landscape.values)"]
    several = len(world.objects) > 1
    if tools:
        alone = f"world.with_object({scene.object!r})" if several else "world"
        names = f"[{', '.join(map(repr, tools))}]"
        python += [f"print(hb.compare({alone}, {names}, {scene.horizon}{_slip(scene)}))"]
    none = ["--tool", NO_TOOL] if bare else []
    verbs = [["habilis", "landscape", _FILE, *none, *_options(scene)]]
    if tools and not several:
        slip = ["--slip", str(scene.slip)] if scene.slip else []
        listed = ["--tools", ",".join(tools), "--horizon", str(scene.horizon)]
        verbs += [["habilis", "compare", _FILE, *listed, *slip]]
    return Written(_script(python), None if tabulated else _shell(world, verbs))


def pairs(scene: Scene, world: World, tools: Sequence[str]) -> Written:
    """Every tool with every object.

    Args:
        scene, world: as for a landscape.
        tools: their names.
    """
    bare = not scene.world.tools and bool(world.tools)
    horizon, names = max(scene.horizon, 1), f"[{', '.join(map(repr, tools))}]"
    python = _opening(world, bare, [])
    python += [f"pairs = hb.pairs(world, {horizon}, {names}{_slip(scene)})"]
    python += ["print(pairs.averages[-1])"]
    command = ["habilis", "compare", _FILE, "--pairs", "--tools", ",".join(tools)]
    command += ["--horizon", str(horizon), *(["--slip", str(scene.slip)] if scene.slip else [])]
    return Written(_script(python), None if bare else _shell(world, [command]))


def game(scene: Scene, world: World, path: Sequence[Placement]) -> Written:
    """The bits of the placements of a game; as a command, those of the last.

    Args:
        scene, world: as for a landscape.
        path: the placements, from the start.
    """
    bare = not scene.world.tools and bool(world.tools)
    sensor, lines = _sensor(scene)
    places = [f"    {_literal(place)}," for place in path]
    python = [*_opening(world, bare, lines), "path = [", *places, "]"]
    # It may have begun where nothing comes to from the map's own placement.
    python += [f"mdp = hb.tabulate(world{_slip(scene)}, starts=path)", *lines]
    python += ["states = [mdp.find(**place) for place in path]"]
    asked = scene.measured.expression("mdp", scene.horizon, sensor, _chosen(scene), "states")
    python += [f"bits = {asked}", "print(bits)"]
    last, command = path[-1], ["habilis", "landscape", _FILE, *_options(scene)]
    command += ["--tool", NO_TOOL] if bare else []
    for name, cell in last.items():
        kind, _, which = name.partition(":")
        if kind in ("tool", "object"):
            place = f"{cell[0]},{cell[1]}"  # type: ignore[index]
            command += [f"--{kind}-at", f"{which}={place}" if which else place]
    hands = [name for name in last if name in ("held", "laid")]
    whole = scene.sensor != "cells" and not hands
    whole &= world.single or not scene.measured.needs_whole
    return Written(_script(python), _shell(world, [command]) if whole else None)


def training(world: World, settings: Mapping[str, Any]) -> Written:
    """A training with some settings of `habilis.learning.config.Config`, and its outcome.

    Args:
        world: the map, with the tool that is used.
        settings: all that are known, those of the algorithm among them.
    """
    from habilis.learning.algorithms import ALGORITHMS
    from habilis.learning.config import Config

    config = Config.from_dict({**settings, "world": _FILE, "tool": None})
    plain = config.as_dict()
    chosen = {
        f.name: plain[f.name]
        for f in fields(Config)
        if f.name not in _NOT_SETTINGS and plain[f.name] != f.default
    }
    name = ALGORITHMS.name_of(config.algorithm)
    kind = type(config.algorithm)
    learner = {
        f.name: plain[f.name]
        for f in fields(kind)
        if getattr(config.algorithm, f.name) != f.default
    }
    given = {"world": _FILE, **chosen, "algorithm": name, **learner}
    python = ["from pathlib import Path", "", "import habilis as hb", ""]
    python += [f"Path({_FILE!r}).write_text({_quoted(world)})", "config = hb.Config.from_dict("]
    python += ["    {", *(f"        {key!r}: {value!r}," for key, value in given.items()), "    }"]
    python += [")", "run = hb.train(config)", "print(run.converged_at, run.best_return)"]
    command = ["habilis", "train", _FILE]
    for key, value in (chosen | {"algorithm": name} | learner).items():
        option = f"--{key.replace('_', '-')}"
        if isinstance(value, bool):
            command += [option if value else f"--no-{option[2:]}"]
        else:
            text = ",".join(map(str, value)) if isinstance(value, list | tuple) else str(value)
            command += [option, text]
    return Written(_script(python), _shell(world, [[*command, "--out", _RUN]]))


def run(folder: Path, index: int, start: Placement | None) -> Written:
    """An episode of a trained agent.

    Args:
        folder: of the run.
        index: which of its runs.
        start: where the episode begins; `None`: where the map has everything.
    """
    python = ["from habilis.learning.folder import load_latest"]
    python += ["from habilis.learning.replay import play, table_of", ""]
    python += [f"run = load_latest({str(folder)!r})"]
    where = ""
    if start is not None:
        python += [f"start = table_of(run).find(**{_literal(start)})"]
        where = ", start"
    python += [f"episode = play(run, {index}{where})"]
    python += ["print(episode.actions, episode.episode_return)"]
    command = f"habilis watch {shlex.quote(str(folder))} --run {index}\n"
    return Written(_script(python), command if start is None else None)


def _opening(world: World, bare: bool, further: Sequence[str]) -> list[str]:
    """Imports and the map."""
    numpy = ["import numpy as np"] if further else []
    lines = ["import habilis as hb", *numpy, "", f"world = hb.World.parse({_quoted(world)})"]
    return lines + ([f"world = world.with_tool({NO_TOOL!r})"] if bare else [])


def _quoted(world: World) -> str:
    """The map as a literal."""
    text = world.located().text().rstrip("\n") + "\n"
    return repr(text) if "\\" in text or '"""' in text else f'"""\\\n{text}"""'


def _sensor(scene: Scene) -> tuple[str, list[str]]:
    """The sensor as an expression, and the lines that define it by `mdp` if it has no name."""
    if scene.sensor != "cells":
        return repr(_name(scene)), []
    cells = [tuple(cell) for cell in scene.cells]
    return "seen", [
        f"at = mdp.factor({scene.seen!r})",
        f"cells = [mdp.label(cell) for cell in {cells}]",
        f"seen = np.where(np.isin(at, cells), at, {ELSEWHERE})",
    ]


def _name(scene: Scene) -> str:
    sensor = scene.sensed(None)  # type: ignore[arg-type]  # only cells need the table
    assert isinstance(sensor, str)
    return sensor


def _arguments(scene: Scene, sensor: str) -> str:
    """Horizon, sensor and actions."""
    return f"{scene.horizon}, {sensor}{_chosen(scene)}"


def _chosen(scene: Scene) -> str:
    actions = scene.action_indices
    return "" if actions is None else f", actions={list(actions)}"


def _slip(scene: Scene) -> str:
    return f", slip={scene.slip}" if scene.slip else ""


def _options(scene: Scene) -> list[str]:
    """The question as options."""
    if scene.sensor == "cells":
        return []
    options = ["--horizon", str(scene.horizon), "--sensor", _name(scene)]
    options += [] if scene.actions == "all" else ["--actions", scene.actions]
    options += scene.measured.options()
    return options + (["--slip", str(scene.slip)] if scene.slip else [])


def _literal(place: Placement) -> str:
    return repr({name: tuple(at) if isinstance(at, list) else at for name, at in place.items()})


def _script(lines: Sequence[str]) -> str:
    return "\n".join(lines) + "\n"


def _shell(world: World, commands: Sequence[Sequence[str]]) -> str:
    """Commands on the map, which they write first."""
    text = world.located().text().rstrip("\n")
    end = _END
    while end in text.splitlines():
        end += "_"
    lines = [f"cat > {_FILE} <<'{end}'", text, end]
    return "\n".join([*lines, *(shlex.join(command) for command in commands)]) + "\n"
