"""Actions that are not available, as the counting kernels read them: they lead nowhere."""

import numpy as np
from jaxtyping import Int32

NO_LABEL = -1
"""The label of a state in which nothing is observed: it adds nothing to a set."""


def with_nowhere(
    table: Int32[np.ndarray, "S A"], labels: Int32[np.ndarray, "S"]
) -> tuple[Int32[np.ndarray, "N A"], Int32[np.ndarray, "N"]]:
    """A table in which unavailable actions lead to one more state, never left, without a label.

    So a sequence with an unavailable action contributes no observation, and the sets are those of
    the complete sequences alone. A table in which every action is available stays as it is.
    """
    if not table.size or table.min() >= 0:
        return table, labels
    nowhere = len(table)
    leading = np.where(table < 0, np.int32(nowhere), table)
    last = np.full((1, table.shape[1]), nowhere, np.int32)
    return np.concatenate([leading, last]), np.append(labels, np.int32(NO_LABEL))
