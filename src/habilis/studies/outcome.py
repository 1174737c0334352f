"""What a reproduction found."""

from dataclasses import asdict, dataclass
from importlib.metadata import version
from pathlib import Path
from typing import Any

from habilis.studies.learned import Claim
from habilis.studies.numbers import Number
from habilis.studies.published import EXPERIMENTS
from habilis.studies.relations import Relation
from habilis.studies.settings import frozen_settings
from habilis.studies.tables import Result, comparisons, table
from habilis.studies.verdicts import in_words, tally


@dataclass(frozen=True, eq=False)
class Reproduction:
    """Everything that was recomputed.

    Attributes:
        folder: where it was written.
        numbers: the paper's numbers about its worlds.
        relations: what the paper states about its worlds.
        learned: what the paper states about its learning agents.
        results: the rows of each table, by the experiment's name.
        budget: of each run.
        quick: whether the budget was the small one.
        seconds: how long it took.
    """

    folder: Path
    numbers: list[Number]
    relations: list[Relation]
    learned: list[Claim]
    results: dict[str, list[Result]]
    budget: dict[str, Any]
    quick: bool
    seconds: float

    @property
    def verdicts(self) -> dict[str, int]:
        """How many statements about the agents hold, are undecided, come out the other way."""
        return tally(claim.outcome for claim in self.learned)

    def summary(self) -> dict[str, Any]:
        """How much agrees, and where the report is."""
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
            f"{s['report']}"
        )

    def as_data(self) -> dict[str, Any]:
        """Everything in the report, as plain values."""
        return {
            "habilis": version("habilis"),
            "quick": self.quick,
            "seconds": round(self.seconds, 1),
            "budget": self.budget,
            "settings": frozen_settings(),
            "numbers": [asdict(n) | {"agrees": n.agrees} for n in self.numbers],
            "relations": [asdict(r) for r in self.relations],
            "learned": [asdict(c) for c in self.learned],
            "verdicts": self.verdicts,
            "tables": {
                e.name: {
                    "rows": table(e, self.results[e.name]).to_dicts(),
                    "converged_at": {
                        result.row.label: list(result.run.converged_at)
                        for result in self.results[e.name]
                    },
                    "comparisons": [
                        asdict(c) | {"outcome": c.outcome, "verdict": c.verdict}
                        for c in comparisons(e, self.results[e.name])
                    ],
                }
                for e in EXPERIMENTS
            },
        }
