"""All that the paper states about empowerment in its worlds."""

from habilis.studies import first_statements, second_statements
from habilis.studies.relations import Relation
from habilis.studies.scenes import Pair, pair


def stated_relations(worlds: Pair | None = None) -> list[Relation]:
    """Every statement that follows from the worlds alone, recomputed, in the paper's order.

    Args:
        worlds: those that they are about; by default those of the reproduction.
    """
    worlds = worlds or pair()
    return [check(worlds) for check in (*first_statements.CHECKS, *second_statements.CHECKS)]
