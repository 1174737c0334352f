"""Every relation that the paper states about empowerment in its worlds, recomputed.

Each function tests one statement, puts what was found into words, and says whether it holds.
"""

from collections.abc import Callable
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from habilis.empowerment import empowerment
from habilis.studies.scenes import BESIDE_CAN, BESIDE_TOOL, FAR_CAN, corridor, yard
from habilis.worlds.plans import solve

HORIZONS = range(1, 9)
"""Where the paper says "always" or "at every h"."""
_SAME = 1e-9  # bits


@dataclass(frozen=True)
class Relation:
    """A statement of the paper, in our words.

    Attributes:
        section: where the paper makes it.
        text: the statement.
        holds: whether it does here.
        found: what we found, with figures.
    """

    section: str
    text: str
    holds: bool
    found: str


def stated_relations() -> list[Relation]:
    """All those that follow from the worlds alone, in the paper's order."""
    return [check() for check in _CHECKS]


def tool_is_the_optimal_way() -> Relation:
    """First experiment: fetching the picker pays."""
    with_tool, bare = solve(corridor().mdp), solve(corridor().with_tool("none").mdp)
    assert with_tool is not None
    steps = "no plan" if bare is None else f"{bare.steps} steps"
    return Relation(
        "IV-B",
        "The shortest plan fetches the picker instead of pushing the can",
        bare is None or with_tool.steps < bare.steps,
        f"{with_tool.steps} steps with the picker, {steps} without",
    )


def picker_is_useful() -> Relation:
    toe, agent = corridor().average(6), corridor().with_tool("none").average(6)
    return Relation(
        "IV-B",
        "The picker has an impact on the can, and a larger one than the bare agent (h = 6)",
        toe > 0 and toe > agent,
        f"average TOE {toe:.2f} bits, average agent's object empowerment {agent:.2f} bits",
    )


def one_step_foe_is_a_beacon_at_the_tool() -> Relation:
    scene = corridor()
    values = scene.landscape(1, "state")
    around = scene.distance(scene.tool_cell) == 1
    least, elsewhere = np.nanmin(values[around]), np.nanmax(values[~around])
    return Relation(
        "IV-B.2",
        "1-step FOE is larger next to the tool than anywhere else",
        bool(least > elsewhere),
        f"at least {least:.2f} bits next to the tool, at most {elsewhere:.2f} bits elsewhere",
    )


def foe_grows_with_the_horizon() -> Relation:
    one, five = corridor().landscape(1, "state"), corridor().landscape(5, "state")
    gain = np.nanmin(five - one)
    return Relation(
        "IV-B.2",
        "5-step FOE is larger than 1-step FOE in every cell",
        bool(gain > 0),
        f"by {gain:.2f} bits at least",
    )


def five_step_foe_is_high_at_tool_and_can_alike() -> Relation:
    scene = corridor()
    tool = scene.beside(5, "state", scene.tool_cell).max()
    can = scene.beside(5, "state", scene.world.object).max()
    rest = np.nanmean(scene.landscape(5, "state"))
    return Relation(
        "IV-B.2",
        "5-step FOE is about equally high around the picker and around the can",
        bool(abs(tool - can) < 0.5 and min(tool, can) > rest + 1),
        f"maxima {tool:.2f} bits next to the picker, {can:.2f} bits next to the can; "
        f"{rest:.2f} bits on average over all cells",
    )


def one_step_toe_is_at_the_can_alone() -> Relation:
    scene = corridor()
    values = scene.landscape(1, "object")
    around = scene.distance(scene.world.object) == 1
    most, elsewhere = np.nanmax(values[around]), np.nanmax(values[~around])
    return Relation(
        "IV-B.2",
        "1-step TOE is 1 bit next to the can (where it can be pushed) and 0 everywhere else",
        bool(most == 1 and elsewhere == 0),
        f"{most:.2f} bits next to the can, {elsewhere:.2f} bits elsewhere",
    )


def six_step_toe_is_higher_at_the_picker() -> Relation:
    scene = corridor()
    tool = scene.beside(6, "object", scene.tool_cell).max()
    can = scene.beside(6, "object", scene.world.object).max()
    return Relation(
        "IV-B.2",
        "6-step TOE has its maximum next to the picker, above that next to the can",
        bool(tool > can and tool == np.nanmax(scene.landscape(6, "object"))),
        f"{tool:.2f} bits next to the picker, {can:.2f} bits next to the can",
    )


def toe_grows_towards_the_can() -> Relation:
    scene = corridor()
    mdp, can = scene.mdp, scene.world.object
    here = mdp.flags["equipped"] & (mdp.factor("object") == can[0] * scene.world.width + can[1])
    states = np.flatnonzero(here)
    bits = empowerment(mdp, 6, "object", states=states)
    distance = scene.distance(can).ravel()[mdp.factor("agent")[states]]
    means = [bits[distance == d].mean() for d in np.unique(distance)]
    return Relation(
        "IV-B.2",
        "With the picker in hand, 6-step TOE grows as the agent comes closer to the can",
        all(near >= far for near, far in pairwise(means)),
        "mean bits by the distance to the can, from 1 cell: "
        + ", ".join(f"{mean:.2f}" for mean in means[:8]),
    )


def goal_has_low_foe() -> Relation:
    scene = corridor()
    values = scene.landscape(5, "state")
    goal, middle = values[scene.world.goal], np.nanmedian(values)
    return Relation(
        "IV-B.2",
        "The goal cell has a low 5-step FOE (below the landscape's median)",
        bool(goal < middle),
        f"{goal:.2f} bits at the goal, median {middle:.2f} bits",
    )


def equipped_lasts() -> Relation:
    mdp = corridor().mdp
    equipped = mdp.flags["equipped"]
    lost = int((~equipped[mdp.next_state[equipped]]).sum())
    return Relation(
        "IV-A",
        "A tool once equipped stays equipped",
        lost == 0,
        f"{lost} of {mdp.next_state[equipped].size:,} transitions lose it",
    )


def attached_lasts() -> Relation:
    mdp = corridor().mdp
    attached = mdp.flags["attached"]
    lost = int((~attached[mdp.next_state[attached]]).sum())
    return Relation(
        "IV-B.2",
        "A can once attached to the picker stays attached",
        lost == 0,
        f"{lost} of {mdp.next_state[attached].size:,} transitions lose it",
    )


def picker_above_broom_above_bare() -> Relation:
    picker, broom, bare = (yard().with_tool(t).average(3) for t in ("picker", "broom", "none"))
    return Relation(
        "IV-C",
        "Average object empowerment ranks the picker above the broom above the bare agent (h = 3)",
        picker > broom > bare,
        f"{picker:.2f}, {broom:.2f}, {bare:.2f} bits",
    )


def broom_adds_the_sideways_push() -> Relation:
    """What the broom can do at once and the agent alone cannot: push from the diagonal."""
    able = {}
    for tool in ("broom", "none"):
        mdp, width = yard().with_tool(tool).mdp, yard().world.width
        row, column = np.divmod(mdp.factor("agent"), width)
        can_row, can_column = np.divmod(mdp.factor("object"), width)
        diagonal = (abs(row - can_row) == 1) & (abs(column - can_column) == 1)
        if tool == "broom":
            diagonal &= mdp.flags["equipped"]
        able[tool] = empowerment(mdp, 1, "object", states=diagonal) > 0
    broom, bare = able["broom"], able["none"]
    return Relation(
        "IV-C",
        "With the broom the agent can push a can that stands diagonally from it; alone it cannot",
        bool(broom.any() and not bare.any()),
        f"possible in {broom.sum():,} of {broom.size:,} such placements with the broom, "
        f"in {bare.sum():,} of {bare.size:,} without",
    )


def foe_cannot_tell_the_tools_apart() -> Relation:
    near = yard().placed(BESIDE_TOOL, BESIDE_CAN)
    picker, broom = near.landscape(1, "state"), near.with_tool("broom").landscape(1, "state")
    apart = np.abs(picker - broom) > _SAME
    return Relation(
        "IV-C.2",
        "With the can next to the tool, the 1-step FOE landscape is the same for broom and picker",
        not apart.any(),
        _difference(apart, picker, broom, "a picker is blocked by a can it does not hold"),
    )


def average_foe_cannot_tell_the_tools_apart() -> Relation:
    picker = yard().average(1, "state")
    broom = yard().with_tool("broom").average(1, "state")
    return Relation(
        "IV-C.2",
        "The average 1-step FOE is the same for broom and picker",
        abs(picker - broom) < _SAME,
        f"{picker:.4f} bits with the picker, {broom:.4f} bits with the broom",
    )


def one_step_toe_tells_the_tools_apart() -> Relation:
    near = yard().placed(BESIDE_TOOL, BESIDE_CAN)
    picker = near.beside(1, "object", BESIDE_TOOL).max()
    broom = near.with_tool("broom").beside(1, "object", BESIDE_TOOL).max()
    return Relation(
        "IV-C.2",
        "1-step TOE next to the tool is larger for the picker than for the broom",
        bool(picker > broom),
        f"{picker:.2f} bits next to the picker, {broom:.2f} bits next to the broom",
    )


def foe_cannot_see_the_can() -> Relation:
    broom = yard().with_tool("broom")
    near = broom.placed(BESIDE_TOOL, BESIDE_CAN).landscape(1, "state")
    far = broom.placed(BESIDE_TOOL, FAR_CAN).landscape(1, "state")
    both = (broom.distance(BESIDE_TOOL) == 1) & np.isfinite(near)
    apart = both & (np.abs(near - far) > _SAME)
    return Relation(
        "IV-C.2",
        "1-step FOE around the broom is the same with the can next to it and far away",
        not apart.any(),
        f"{both.sum() - apart.sum()} of the {both.sum()} free cells around the broom agree",
    )


def toe_is_zero_far_from_the_can() -> Relation:
    found, holds = [], True
    for tool in ("picker", "broom"):
        far = yard().with_tool(tool).placed(BESIDE_TOOL, FAR_CAN)
        for horizon in (1, 2, 3):
            values = far.landscape(horizon, "object")
            at_tool = np.nanmax(values[far.distance(BESIDE_TOOL) == 1])
            at_can = np.nanmax(values[far.distance(FAR_CAN) <= horizon])
            holds &= bool(at_tool == 0 < at_can)
            found.append(f"{at_tool:.1f}/{at_can:.1f}")
    return Relation(
        "IV-C.2",
        "With the can far from the tool, TOE is 0 around the tool and not around the can "
        "(h = 1, 2, 3; picker, broom)",
        holds,
        "maxima around tool/can: " + ", ".join(found) + " bits",
    )


def foe_can_be_larger_for_the_broom() -> Relation:
    larger = []
    for horizon in range(1, 6):
        picker, broom = (yard().with_tool(t).average(horizon, "state") for t in ("picker", "broom"))
        if broom > picker:
            larger.append(f"h = {horizon}: {broom:.3f} over {picker:.3f}")
    return Relation(
        "IV-C.2",
        "At larger horizons (h up to 5 tried) the average FOE can be larger for the broom "
        "than for the picker",
        any(not text.startswith("h = 1:") for text in larger),
        "; ".join(larger) + " bits" if larger else "never larger for the broom",
    )


def toe_always_ranks_the_picker_above_the_broom() -> Relation:
    gaps = _toe_gaps()
    return Relation(
        "IV-C.2",
        f"Average TOE of the picker is above the broom's at every h (1 to {HORIZONS[-1]})",
        min(gaps) > 0,
        "picker minus broom: " + ", ".join(f"{gap:.3f}" for gap in gaps) + " bits",
    )


def toe_gap_grows_with_the_horizon() -> Relation:
    gaps = _toe_gaps()
    return Relation(
        "IV-C.2",
        f"That gap grows with h (1 to {HORIZONS[-1]})",
        all(later > earlier for earlier, later in pairwise(gaps)),
        "picker minus broom: " + ", ".join(f"{gap:.3f}" for gap in gaps) + " bits",
    )


def _toe_gaps() -> list[float]:
    picker, broom = yard(), yard().with_tool("broom")
    return [picker.average(h) - broom.average(h) for h in HORIZONS]


def _difference(apart: np.ndarray, a: np.ndarray, b: np.ndarray, why: str) -> str:
    total = int(np.isfinite(a).sum())
    if not apart.any():
        return f"all {total} cells agree"
    most = np.nanmax(np.abs(a - b))
    return (
        f"{total - apart.sum()} of {total} cells agree, "
        f"the others differ by at most {most:.2f} bits ({why})"
    )


_CHECKS: tuple[Callable[[], Relation], ...] = (
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
    picker_above_broom_above_bare,
    broom_adds_the_sideways_push,
    foe_cannot_tell_the_tools_apart,
    average_foe_cannot_tell_the_tools_apart,
    one_step_toe_tells_the_tools_apart,
    foe_cannot_see_the_can,
    toe_is_zero_far_from_the_can,
    foe_can_be_larger_for_the_broom,
    toe_always_ranks_the_picker_above_the_broom,
    toe_gap_grows_with_the_horizon,
)
