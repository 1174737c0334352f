"""Estimators of one's own, named by where they are written: `mine.py:Mine`."""

from habilis.estimators.protocol import Estimator, is_estimator
from habilis.files import shown
from habilis.own_code import BETWEEN, FILE, imported, instance, member, read, run

_EXAMPLE = "mine.py:Mine"


def own_estimator(name: str) -> Estimator:
    """The estimator that a file or a module has.

    Args:
        name: `FILE.py:CLASS` or `package.module:CLASS`. The class needs no arguments; in its place
            the name of an instance will do.

    Returns:
        An instance.

    Raises:
        ValueError: there is none, or the code fails; the message says how to fix it.
    """
    place, _, wanted = name.rpartition(BETWEEN)
    try:
        if place.endswith(FILE):
            module = run(place, *read(place, _EXAMPLE))
        else:
            module = imported(place, _EXAMPLE)
        made = instance(member(module, wanted))
    except ValueError as error:
        raise ValueError(f"estimator {shown(repr(name))}: {error}") from None
    if not is_estimator(made):
        raise ValueError(
            f"estimator {shown(repr(name))}: it has no method fit; give it "
            "fit(simulator, horizon, sensor, *, seed)"
        )
    return made
