"""All that the paper states about empowerment in its worlds."""

from habilis.studies import first_statements, second_statements
from habilis.studies.relations import Relation


def stated_relations() -> list[Relation]:
    """Every statement that follows from the worlds alone, recomputed, in the paper's order."""
    return [check() for check in (*first_statements.CHECKS, *second_statements.CHECKS)]
