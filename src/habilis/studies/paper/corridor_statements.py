"""The paper's statements about its rules and its first world, recomputed.

Each function tests one statement: whether it holds, and the finding in words.
"""

from collections.abc import Callable
from itertools import pairwise

import numpy as np

from habilis.empowerment import empowerment
from habilis.mdp import TabularMDP
from habilis.studies.paper.findings import Statement
from habilis.studies.paper.worlds import PaperWorlds
from habilis.worlds.plans import solve


def tool_is_the_optimal_way(worlds: PaperWorlds) -> Statement:
    """First experiment: fetching the picker pays."""
    with_tool, bare = solve(worlds.corridor.mdp), solve(worlds.corridor.with_tool("none").mdp)
    assert with_tool is not None
    steps = "no plan" if bare is None else f"{bare.steps} steps"
    return Statement(
        "IV-B",
        "The shortest plan fetches the picker instead of pushing the can",
        bare is None or with_tool.steps < bare.steps,
        f"{with_tool.steps} steps with the picker, {steps} without",
    )


def picker_is_useful(worlds: PaperWorlds) -> Statement:
    toe, agent = worlds.corridor.average(6), worlds.corridor.with_tool("none").average(6)
    return Statement(
        "IV-B",
        "The picker has an impact on the can, and a larger one than the bare agent (h = 6)",
        toe > 0 and toe > agent,
        f"average TOE {toe:.2f} bits, average agent's object empowerment {agent:.2f} bits",
    )


def one_step_foe_is_a_beacon_at_the_tool(worlds: PaperWorlds) -> Statement:
    corridor = worlds.corridor
    values = corridor.landscape(1, "state").values
    around = corridor.distance(corridor.tool_cell) == 1
    least, elsewhere = np.nanmin(values[around]), np.nanmax(values[~around])
    return Statement(
        "IV-B.2",
        "1-step FOE is larger next to the tool than anywhere else",
        bool(least > elsewhere),
        f"at least {least:.2f} bits next to the tool, at most {elsewhere:.2f} bits elsewhere",
    )


def foe_grows_with_the_horizon(worlds: PaperWorlds) -> Statement:
    one, five = (
        worlds.corridor.landscape(1, "state").values,
        worlds.corridor.landscape(5, "state").values,
    )
    gain = np.nanmin(five - one)
    return Statement(
        "IV-B.2",
        "5-step FOE is larger than 1-step FOE in every cell",
        bool(gain > 0),
        f"by {gain:.2f} bits at least",
    )


def five_step_foe_is_high_at_tool_and_can_alike(worlds: PaperWorlds) -> Statement:
    corridor = worlds.corridor
    tool = corridor.beside(5, "state", corridor.tool_cell).max()
    can = corridor.beside(5, "state", corridor.world.object).max()
    rest = np.nanmean(corridor.landscape(5, "state").values)
    return Statement(
        "IV-B.2",
        "5-step FOE is about equally high around the picker and around the can (maxima within half "
        "a bit of each other and a bit above the average)",
        bool(abs(tool - can) < 0.5 and min(tool, can) > rest + 1),
        f"maxima {tool:.2f} bits next to the picker, {can:.2f} bits next to the can; "
        f"{rest:.2f} bits on average over all cells",
    )


def one_step_toe_is_at_the_can_alone(worlds: PaperWorlds) -> Statement:
    corridor = worlds.corridor
    values = corridor.landscape(1, "object").values
    around = corridor.distance(corridor.world.object) == 1
    beside, elsewhere = values[around & np.isfinite(values)], np.nanmax(values[~around])
    return Statement(
        "IV-B.2",
        "1-step TOE is at most 1 bit, has that in cells next to the can, and is 0 in all others",
        bool(set(beside) <= {0, 1} and beside.max() == 1 and elsewhere == 0),
        f"1 bit in {(beside == 1).sum()} of the {beside.size} free cells next to the can (from the "
        f"rest it cannot be pushed), {elsewhere:.2f} bits elsewhere",
    )


def six_step_toe_is_higher_at_the_picker(worlds: PaperWorlds) -> Statement:
    corridor = worlds.corridor
    tool = corridor.beside(6, "object", corridor.tool_cell).max()
    can = corridor.beside(6, "object", corridor.world.object).max()
    return Statement(
        "IV-B.2",
        "6-step TOE has its maximum next to the picker, above that next to the can",
        bool(tool > can and tool == np.nanmax(corridor.landscape(6, "object").values)),
        f"{tool:.2f} bits next to the picker, {can:.2f} bits next to the can",
    )


def toe_grows_towards_the_can(worlds: PaperWorlds) -> Statement:
    corridor = worlds.corridor
    mdp, can = corridor.mdp, corridor.world.object
    here = mdp.flags["equipped"] & (mdp.factor("object") == can[0] * corridor.world.width + can[1])
    states = np.flatnonzero(here)
    bits = empowerment(mdp, 6, "object", states=states)
    distance = corridor.distance(can).ravel()[mdp.factor("agent")[states]]
    means = [bits[distance == d].mean() for d in np.unique(distance)]
    return Statement(
        "IV-B.2",
        "With the picker in hand, 6-step TOE grows as the agent comes closer to the can",
        all(near >= far for near, far in pairwise(means)),
        "mean bits by the distance to the can, from 1 cell: "
        + ", ".join(f"{mean:.2f}" for mean in means[:8]),
    )


def goal_has_low_foe(worlds: PaperWorlds) -> Statement:
    corridor = worlds.corridor
    values = corridor.landscape(5, "state").values
    goal, middle = values[corridor.world.goal], np.nanmedian(values)
    return Statement(
        "IV-B.2",
        "The goal cell has a low 5-step FOE (below the landscape's median)",
        bool(goal < middle),
        f"{goal:.2f} bits at the goal, median {middle:.2f} bits",
    )


def tool_actions_need_the_tool(worlds: PaperWorlds) -> Statement:
    changed = total = 0
    for mdp in _tables_with_tools(worlds):
        lying = ~mdp.flags["equipped"]
        reached = mdp.next_state[lying, 4:]
        changed += int((reached != np.flatnonzero(lying)[:, None]).sum())
        total += reached.size
    return Statement(
        "IV-A",
        "Tool actions have no effect unless the tool is equipped",
        changed == 0 < total,
        f"{changed} of {total:,} such actions change the state",
    )


def equipped_lasts(worlds: PaperWorlds) -> Statement:
    lost = total = 0
    for mdp in _tables_with_tools(worlds):
        equipped = mdp.flags["equipped"]
        reached = mdp.next_state[equipped]
        lost += int((~equipped[reached]).sum())
        total += reached.size
    return Statement(
        "IV-A",
        "A tool once equipped stays equipped",
        lost == 0 < total,
        f"{lost} of {total:,} transitions lose it",
    )


def _tables_with_tools(worlds: PaperWorlds) -> list[TabularMDP]:
    return [
        corridor.with_tool(t).mdp
        for corridor in (worlds.corridor, worlds.yard)
        for t in ("picker", "broom")
    ]


def attached_lasts(worlds: PaperWorlds) -> Statement:
    mdp = worlds.corridor.mdp
    attached = mdp.flags["attached"]
    lost = int((~attached[mdp.next_state[attached]]).sum())
    return Statement(
        "IV-B.2",
        "A can once attached to the picker stays attached",
        lost == 0,
        f"{lost} of {mdp.next_state[attached].size:,} transitions lose it",
    )


CHECKS: tuple[Callable[[PaperWorlds], Statement], ...] = (
    tool_actions_need_the_tool,
    equipped_lasts,
    tool_is_the_optimal_way,
    picker_is_useful,
    one_step_foe_is_a_beacon_at_the_tool,
    foe_grows_with_the_horizon,
    five_step_foe_is_high_at_tool_and_can_alike,
    one_step_toe_is_at_the_can_alone,
    six_step_toe_is_higher_at_the_picker,
    toe_grows_towards_the_can,
    goal_has_low_foe,
    attached_lasts,
)
