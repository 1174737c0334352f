"""Every number that the paper states about its worlds, recomputed."""

from dataclasses import dataclass

import numpy as np

from habilis.studies.scenes import BESIDE_CAN, BESIDE_TOOL, corridor, yard
from habilis.worlds.plans import solve


@dataclass(frozen=True)
class Number:
    """A published number beside ours.

    Attributes:
        section: where the paper states it.
        text: what it is.
        published: as printed, so with the digits that were published.
        ours: not rounded.
        unit: "bits" or "steps", or "" for returns.
    """

    section: str
    text: str
    published: str
    ours: float
    unit: str

    @property
    def agrees(self) -> bool:
        """Whether ours, rounded to the published digits, is the published number."""
        digits = len(self.published.partition(".")[2])
        return round(self.ours, digits) == float(self.published)


def published_numbers() -> list[Number]:
    """All of them, in the paper's order."""
    first, second = corridor(), yard()
    bare, broom = second.with_tool("none"), second.with_tool("broom")
    plan, plan_picker, plan_broom = solve(first.mdp), solve(second.mdp), solve(broom.mdp)
    assert plan is not None and plan_picker is not None and plan_broom is not None  # noqa: PT018

    near_tool = first.beside(1, "state", first.tool_cell)
    near = second.placed(BESIDE_TOOL, BESIDE_CAN)
    far_foe = first.landscape(5, "state")
    toe = first.landscape(1, "object")

    return [
        Number("IV-B", "fewest steps, with the picker", "15", plan.steps, "steps"),
        Number(
            "IV-B",
            "average agent's object empowerment, h = 6",
            "0.6",
            first.with_tool("none").average(6),
            "bits",
        ),
        Number("IV-B", "average tool's object empowerment, h = 6", "1.4", first.average(6), "bits"),
        Number("IV-B.2", "1-step FOE next to the tool, least", "2.6", near_tool.min(), "bits"),
        Number("IV-B.2", "1-step FOE next to the tool, most", "3", near_tool.max(), "bits"),
        Number(
            "IV-B.2",
            "5-step FOE, maximum (here between picker and can)",
            "7",
            _peak(far_foe),
            "bits",
        ),
        Number("IV-B.2", "1-step TOE, maximum", "1", _peak(toe), "bits"),
        Number(
            "IV-B.2",
            "6-step TOE, maximum next to the picker",
            "4.3",
            first.beside(6, "object", first.tool_cell).max(),
            "bits",
        ),
        Number(
            "IV-B.2",
            "6-step TOE, maximum next to the can",
            "3.6",
            first.beside(6, "object", first.world.object).max(),
            "bits",
        ),
        Number("IV-C", "average TOE of the broom, h = 3", "0.28", broom.average(3), "bits"),
        Number(
            "IV-C", "average agent's object empowerment, h = 3", "0.23", bare.average(3), "bits"
        ),
        Number("IV-C", "average TOE of the picker, h = 3", "0.52", second.average(3), "bits"),
        Number("IV-C.1", "best return with the picker", "-10", plan_picker.best_return, ""),
        Number("IV-C.1", "best return with the broom", "-12", plan_broom.best_return, ""),
        Number(
            "IV-C.2",
            "1-step TOE with the can next to the tool, maximum next to the picker",
            "3",
            near.beside(1, "object", BESIDE_TOOL).max(),
            "bits",
        ),
        Number(
            "IV-C.2",
            "1-step TOE with the can next to the tool, maximum next to the broom",
            "1",
            near.with_tool("broom").beside(1, "object", BESIDE_TOOL).max(),
            "bits",
        ),
    ]


def _peak(values) -> float:
    return float(np.nanmax(values))
