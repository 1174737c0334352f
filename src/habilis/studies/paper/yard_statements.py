"""The paper's statements about its second world and the two tools, recomputed.

Each function tests one statement: whether it holds, and the finding in words.
"""

from collections.abc import Callable
from itertools import pairwise

import numpy as np

from habilis.analysis.averages import compared_states
from habilis.empowerment import empowerment
from habilis.studies.paper.findings import Statement
from habilis.studies.paper.worlds import PaperWorlds

HORIZONS = range(1, 31)
"""The horizons tested where the paper says "always"."""
USED_HORIZONS = range(1, 7)
"""Up to the largest horizon that the paper computes anything for."""
_SAME = 1e-9  # bits


def picker_above_broom_above_bare(worlds: PaperWorlds) -> Statement:
    picker, broom, bare = (worlds.yard.with_tool(t).average(3) for t in ("picker", "broom", "none"))
    return Statement(
        "IV-C",
        "Average object empowerment ranks the picker above the broom above the bare agent (h = 3)",
        picker > broom > bare,
        f"{picker:.2f}, {broom:.2f}, {bare:.2f} bits",
    )


def broom_adds_the_sideways_push(worlds: PaperWorlds) -> Statement:
    """The broom's immediate advantage over the agent alone: a push from the diagonal."""
    broom, bare = _able_by_offset(worlds, "broom"), _able_by_offset(worlds, "none")
    return Statement(
        "IV-C",
        "With the broom the agent can push a can that stands diagonally from it; alone it cannot",
        bool(broom[1, 1] > 0 and bare[1, 1] == 0),
        f"in {broom[1, 1]:,} placements with the broom, in {bare[1, 1]:,} without",
    )


def broom_adds_nothing_else(worlds: PaperWorlds) -> Statement:
    broom, bare = _able_by_offset(worlds, "broom"), _able_by_offset(worlds, "none")
    more = {o: int(broom[o]) for o in np.ndindex(3, 3) if o != (1, 1) and broom[o] and not bare[o]}
    in_line = more.get((0, 2), 0) + more.get((2, 0), 0)
    return Statement(
        "IV-C",
        "The broom adds no other way of moving the can in one step",
        not more,
        f"also in {in_line:,} placements in which the can is two cells away in line, pushed by a "
        "broom between"
        if more
        else "none found",
    )


def _able_by_offset(worlds: PaperWorlds, tool: str) -> np.ndarray:
    """int[3, 3]: placements with some 1-step TOE, by rows and columns from agent to can."""
    mdp, width = worlds.yard.with_tool(tool).mdp, worlds.yard.world.width
    states = np.flatnonzero(compared_states(mdp))
    able = states[empowerment(mdp, 1, "object", states=states) > 0]
    agent, can = mdp.factor("agent")[able], mdp.factor("object")[able]
    rows, columns = abs(agent // width - can // width), abs(agent % width - can % width)
    near = (rows < 3) & (columns < 3)
    return np.bincount(3 * rows[near] + columns[near], minlength=9).reshape(3, 3)


def foe_cannot_tell_the_tools_apart(worlds: PaperWorlds) -> Statement:
    near = worlds.yard
    picker, broom = (
        near.landscape(1, "state").values,
        near.with_tool("broom").landscape(1, "state").values,
    )
    apart = np.abs(picker - broom) > _SAME
    return Statement(
        "IV-C.2",
        "With the can next to the tool, the 1-step FOE landscape is the same for broom and picker",
        not apart.any(),
        _difference(apart, picker, broom, "a picker is blocked by a can it does not hold"),
    )


def average_foe_cannot_tell_the_tools_apart(worlds: PaperWorlds) -> Statement:
    picker = worlds.yard.average(1, "state")
    broom = worlds.yard.with_tool("broom").average(1, "state")
    return Statement(
        "IV-C.2",
        "The average 1-step FOE is the same for broom and picker",
        abs(picker - broom) < _SAME,
        f"{picker:.4f} bits with the picker, {broom:.4f} bits with the broom",
    )


def one_step_toe_tells_the_tools_apart(worlds: PaperWorlds) -> Statement:
    near = worlds.yard
    picker = near.beside(1, "object", near.tool_cell).max()
    broom = near.with_tool("broom").beside(1, "object", near.tool_cell).max()
    return Statement(
        "IV-C.2",
        "1-step TOE next to the tool is larger for the picker than for the broom",
        bool(picker > broom),
        f"{picker:.2f} bits next to the picker, {broom:.2f} bits next to the broom",
    )


def foe_cannot_see_the_can(worlds: PaperWorlds) -> Statement:
    broom = worlds.yard.with_tool("broom")
    near = broom.landscape(1, "state").values
    far = broom.with_object_far().landscape(1, "state").values
    both = (broom.distance(broom.tool_cell) == 1) & np.isfinite(near)
    apart = both & (np.abs(near - far) > _SAME)
    return Statement(
        "IV-C.2",
        "1-step FOE around the broom is the same with the can next to it and far away",
        not apart.any(),
        f"{both.sum() - apart.sum()} of the {both.sum()} free cells around the broom agree",
    )


def toe_is_zero_far_from_the_can(worlds: PaperWorlds) -> Statement:
    found, holds = [], True
    for tool in ("picker", "broom"):
        far = worlds.yard.with_tool(tool).with_object_far()
        for horizon in (1, 2, 3):
            values = far.landscape(horizon, "object").values
            at_tool = np.nanmax(values[far.distance(far.tool_cell) == 1])
            at_can = np.nanmax(values[far.distance(far.world.object) <= horizon])
            elsewhere = np.nanmax(values[far.distance(far.world.object) > horizon])
            holds &= bool(at_tool == elsewhere == 0 < at_can)
            found.append(f"{at_tool:.1f}/{at_can:.1f}/{elsewhere:.1f}")
    return Statement(
        "IV-C.2",
        "With the can far from the tool, TOE is 0 around the tool, and not 0 only around the can, "
        "from where h steps reach it (h = 1, 2, 3; picker, broom)",
        holds,
        "maxima around tool/can/elsewhere: " + ", ".join(found) + " bits",
    )


def foe_can_be_larger_for_the_broom(worlds: PaperWorlds) -> Statement:
    larger = []
    for horizon in range(2, 6):
        picker, broom = (
            worlds.yard.with_tool(t).average(horizon, "state") for t in ("picker", "broom")
        )
        if broom > picker:
            larger.append(f"h = {horizon}: {broom:.3f} over {picker:.3f}")
    return Statement(
        "IV-C.2",
        "At larger horizons (h = 2 to 5) the average FOE can be larger for the broom",
        bool(larger),
        "; ".join(larger) + " bits" if larger else "never larger for the broom",
    )


def foe_near_the_tool_can_be_larger_for_the_broom(worlds: PaperWorlds) -> Statement:
    near = worlds.yard
    larger = []
    for horizon in range(2, 6):
        picker = near.beside(horizon, "state", near.tool_cell).max()
        broom = near.with_tool("broom").beside(horizon, "state", near.tool_cell).max()
        if broom > picker:
            larger.append(f"h = {horizon}: {broom:.2f} over {picker:.2f}")
    return Statement(
        "IV-C.2",
        "At larger horizons (h = 2 to 5) FOE next to the tool can be larger for the broom",
        bool(larger),
        "; ".join(larger) + " bits" if larger else "never larger for the broom",
    )


def toe_always_ranks_the_picker_above_the_broom(worlds: PaperWorlds) -> Statement:
    gaps = _toe_gaps(worlds, HORIZONS)
    return Statement(
        "IV-C.2",
        f"Average TOE of the picker is above the broom's at every h (1 to {HORIZONS[-1]})",
        min(gaps) > 0,
        f"by {min(gaps):.3f} bits at least, by {max(gaps):.3f} at most",
    )


def toe_gap_grows_with_the_horizon(worlds: PaperWorlds) -> Statement:
    gaps = _toe_gaps(worlds, HORIZONS)
    used, peak = gaps[: len(USED_HORIZONS)], int(np.argmax(gaps))
    then = f"; it grows up to h = {HORIZONS[peak]} ({gaps[peak]:.2f} bits)"
    if peak + 1 < len(gaps):
        then += f" and shrinks from there ({gaps[-1]:.2f} bits at h = {HORIZONS[-1]})"
    return Statement(
        "IV-C.2",
        f"That gap grows with h (1 to {USED_HORIZONS[-1]}, the horizons that the paper uses)",
        all(later > earlier for earlier, later in pairwise(used)),
        "picker minus broom: " + ", ".join(f"{gap:.3f}" for gap in used) + " bits" + then,
    )


def _toe_gaps(worlds: PaperWorlds, horizons: range) -> list[float]:
    picker, broom = worlds.yard, worlds.yard.with_tool("broom")
    return [picker.average(h) - broom.average(h) for h in horizons]


def _difference(apart: np.ndarray, a: np.ndarray, b: np.ndarray, why: str) -> str:
    total = int(np.isfinite(a).sum())
    if not apart.any():
        return f"all {total} cells agree"
    most = np.nanmax(np.abs(a - b))
    return (
        f"{total - apart.sum()} of {total} cells agree, "
        f"the others differ by at most {most:.2f} bits ({why})"
    )


CHECKS: tuple[Callable[[PaperWorlds], Statement], ...] = (
    picker_above_broom_above_bare,
    broom_adds_the_sideways_push,
    broom_adds_nothing_else,
    foe_cannot_tell_the_tools_apart,
    average_foe_cannot_tell_the_tools_apart,
    one_step_toe_tells_the_tools_apart,
    foe_cannot_see_the_can,
    toe_is_zero_far_from_the_can,
    foe_can_be_larger_for_the_broom,
    foe_near_the_tool_can_be_larger_for_the_broom,
    toe_always_ranks_the_picker_above_the_broom,
    toe_gap_grows_with_the_horizon,
)
