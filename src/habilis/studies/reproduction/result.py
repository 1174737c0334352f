"""The result of a reproduction."""

from dataclasses import asdict, dataclass, replace
from functools import cached_property
from importlib.metadata import version
from pathlib import Path
from typing import Any

from habilis.reprs import counted, short, unfailing
from habilis.studies.comparison import in_words, tally
from habilis.studies.pace.data import MEASURES, Pace
from habilis.studies.pace.slowness import WAYS, Association, association
from habilis.studies.paper.findings import AgentStatement, Number, Statement
from habilis.studies.paper.published import EXPERIMENTS
from habilis.studies.paper.settings import learner_settings
from habilis.studies.paper.tables import Result, row_orders, table
from habilis.worlds.world import World


@dataclass(frozen=True, eq=False)
class Reproduction:
    """Everything that was recomputed.

    Attributes:
        folder: where it was written.
        numbers: the paper's numbers about its worlds.
        relations: what the paper states about its worlds.
        learned: what the paper states about its learning agents.
        results: the rows of each table, by the experiment's name.
        pace: what was calibrated and trained before, at the paper's pace.
        budget: of each run.
        quick: whether the budget was the small one.
        seconds: how long it took.
    """

    folder: Path
    numbers: list[Number]
    relations: list[Statement]
    learned: list[AgentStatement]
    results: dict[str, list[Result]]
    pace: Pace
    budget: dict[str, Any]
    quick: bool
    seconds: float

    @unfailing
    def __repr__(self) -> str:
        return short(
            "Reproduction",
            str(self.folder),
            f"{counted(len(self.numbers), 'number')} about worlds",
            f"agents: {in_words(self.verdicts)}",
            "quick" if self.quick else "",
        )

    @property
    def verdicts(self) -> dict[str, int]:
        """The numbers of statements about the agents that hold, are undecided, are opposite."""
        return tally(claim.outcome for claim in self.learned)

    @property
    def ensemble_verdicts(self) -> dict[str, int]:
        """The same of the orders over the ensemble; all 0 without one."""
        return tally(claim.ensemble for claim in self.learned if claim.ensemble is not None)

    @property
    def other_worlds(self) -> list[World]:
        """The maps on which the tables' agents acted, unless they are the built-in ones."""
        worlds = [replace(r.run.map, name=r.map) for r, *_ in self.results.values()]
        built_in = {e.world for e in EXPERIMENTS}
        return [world for world in worlds if world.name not in built_in]

    @cached_property
    def associations(self) -> list[Association]:
        """The associations of the ratio, and of the order, with slowness."""
        learners = self.pace.learners
        found = [association(learners, measure, by) for measure in MEASURES for by in WAYS]
        return [one for one in found if one is not None]

    def summary(self) -> dict[str, Any]:
        """The counts of what agrees, and the path of the report."""
        verdicts = self.verdicts
        return {
            "report": str(self.folder / "report.html"),
            "numbers": len(self.numbers),
            "numbers_agree": sum(number.agrees for number in self.numbers),
            "relations": len(self.relations),
            "relations_hold": sum(relation.holds for relation in self.relations),
            "learned": len(self.learned),
            "learned_hold": verdicts["holds"],
            "learned_undecided": verdicts["undecided"],
            "learned_opposite": verdicts["opposite"],
            "seconds": round(self.seconds, 1),
        }

    def text(self) -> str:
        """The summary in words."""
        s = self.summary()
        return (
            f"{s['numbers_agree']} of {s['numbers']} published numbers agree, "
            f"{s['relations_hold']} of {s['relations']} statements about the worlds hold\n"
            f"{s['learned']} statements about the learning agents: {in_words(self.verdicts)}\n"
            f"written to {s['report']}"
        )

    def as_data(self) -> dict[str, Any]:
        """Everything in the report, as plain values."""
        return {
            "habilis": version("habilis"),
            "quick": self.quick,
            "seconds": round(self.seconds, 1),
            "budget": self.budget,
            "settings": learner_settings(self.pace.best),
            "numbers": [asdict(n) | {"agrees": n.agrees} for n in self.numbers],
            "relations": [asdict(r) for r in self.relations],
            "learned": [asdict(c) for c in self.learned],
            "verdicts": self.verdicts,
            "ensemble_verdicts": self.ensemble_verdicts,
            "slowness": [asdict(a) | {"outcome": a.outcome} for a in self.associations],
            "missing": list(self.pace.missing),
            "decided_after": list(self.pace.after),
            "tables": {
                e.name: {
                    "rows": table(e, self.results[e.name], self.pace).to_dicts(),
                    "converged_at": {
                        result.row.label: list(result.run.converged_at)
                        for result in self.results[e.name]
                    },
                    "comparisons": [
                        order.as_dict() for order in row_orders(e, self.results[e.name])
                    ],
                }
                for e in EXPERIMENTS
            },
        }
