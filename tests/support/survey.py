"""Every small environment of Minigrid and toy-text: its table by ours, and by a search of its own.

    python tests/support/survey.py docs/explanation/environments.csv [SECONDS]

Goes on where it was stopped: environments that are in the file are left out. A search takes at most
so many seconds of the processor (default 300).
"""

import csv
import pickle
import sys
import time
from collections.abc import Hashable
from pathlib import Path
from typing import Any

import gymnasium
import minigrid  # noqa: F401  # registers its environments

import habilis as hb

MOST = 20_000
COLUMNS = ("environment", "states", "transitions", "verified", "seconds", "outcome")


def names() -> list[str]:
    """Those of toy-text, and of Minigrid but for BabyAI's levels; those with many things last."""
    modules = ("gymnasium.envs.toy_text", "minigrid.envs")
    many = ("KeyCorridor", "ObstructedMaze", "LockedRoom", "Playground", "Unlock", "WFC", "N3")
    found = [
        name
        for name, spec in sorted(gymnasium.registry.items())
        if str(spec.entry_point).startswith(modules) and "BabyAI" not in name
    ]
    return sorted(found, key=lambda name: any(part in name for part in many))


def seen(env: Any) -> Hashable:
    """The visible state of a Minigrid, and the contents of its boxes."""

    def thing(one: Any) -> Hashable:
        return None if one is None else (one.encode(), thing(getattr(one, "contains", None)))

    boxes = tuple(
        (i, thing(one)) for i, one in enumerate(env.grid.grid) if getattr(one, "contains", None)
    )
    position = tuple(map(int, env.agent_pos))
    return env.grid.encode().tobytes(), boxes, position, int(env.agent_dir), thing(env.carrying)


def searched(name: str, seconds: float) -> dict[Hashable, list[Hashable]]:
    """Where each action leads, by a search of its own; situations that ended have no actions."""
    env: Any = gymnasium.make(name).unwrapped
    env.reset(seed=0)
    found: dict[Hashable, list[Hashable]] = {(seen(env), False): []}
    todo = [((seen(env), False), pickle.dumps(env))]
    began = time.process_time()
    while todo:
        if time.process_time() - began > seconds:
            raise ValueError(f"not decided: {len(found):,} situations in {seconds:g} s")
        here, kept = todo.pop()
        for action in range(env.action_space.n):
            after: Any = pickle.loads(kept)
            after.step_count = 0
            ended = bool(after.step(action)[2])
            there = (seen(after), ended)
            found[here].append(there)
            if there not in found:
                found[there] = []
                if not ended:
                    todo.append((there, pickle.dumps(after)))
        if len(found) > MOST:
            raise ValueError(f"more than {MOST:,} states")
    return found


def refused_soon(env: Any) -> None:
    """Raises ValueError: for another reason than that there are many states."""
    try:
        hb.TabularMDP.from_gymnasium(env, max_states=100)
    except ValueError as error:
        if "raise max_states" not in str(error):
            raise


def outcome(name: str, seconds: float) -> tuple[str, ...]:
    """A row of the table."""
    began = time.perf_counter()
    try:
        env = gymnasium.make(name)
        refused_soon(env)
        found = searched(name, seconds) if name.startswith("MiniGrid") else {}
        mdp = hb.TabularMDP.from_gymnasium(env, max_states=MOST)
    except (ValueError, gymnasium.error.Error) as error:
        spent = f"{time.perf_counter() - began:.0f}"
        kind = "" if "not decided" in str(error) else "refused: "
        return name, "", "", "", spent, f"{kind}{error}"
    spent = f"{time.perf_counter() - began:.0f}"
    transitions = int((~mdp.terminal).sum()) * mdp.action_count
    assert mdp.origin is not None
    counts = (str(mdp.states), str(transitions), str(mdp.origin.verified), spent)
    return name, *counts, matched(mdp, found) if found else "its own table P"


def matched(mdp: hb.TabularMDP, found: dict[Hashable, list[Hashable]]) -> str:
    """Whether a table and a search lead everywhere to the same."""
    first = next(iter(found))
    of_state, todo = {mdp.start: first}, [mdp.start]
    while todo:
        state = todo.pop()
        for action, there in enumerate(found[of_state[state]]):
            reached = int(mdp.next_state[state, action])
            if reached not in of_state:
                of_state[reached] = there
                todo.append(reached)
            if of_state[reached] != there or bool(mdp.terminal[reached]) != there[1]:  # type: ignore
                return f"DIFFERENT: action {action} in state {state}"
    if len(set(of_state.values())) != len(found) or len(of_state) != mdp.states:
        return f"DIFFERENT: {len(of_state)} states, {len(found)} situations"
    if len(of_state) != len(found):
        return f"right: {len(found)} situations, things that look alike reported apart"
    return "right"


def main(path: Path, seconds: float = 300.0) -> None:
    done = set()
    if path.exists():
        with path.open(newline="") as file:
            done = {row["environment"] for row in csv.DictReader(file)}
    else:
        path.write_text(",".join(COLUMNS) + "\n")
    for name in names():
        if name not in done:
            row = outcome(name, seconds)
            with path.open("a", newline="") as file:
                csv.writer(file, lineterminator="\n").writerow(row)
            print(*row, flush=True)


if __name__ == "__main__":
    main(Path(sys.argv[1]), *map(float, sys.argv[2:]))
