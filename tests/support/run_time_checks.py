"""Run-time checks of annotations, array shapes included.

`--jaxtyping-packages` (pyproject.toml) names the modules, of which every function and dataclass is
decorated with `checked` as they are imported. Processes that tests start are not checked.
"""

import ast
import random
import sys
from collections.abc import Callable
from functools import wraps
from importlib import import_module
from pathlib import Path
from typing import Any

from beartype import BeartypeConf, beartype

_CONF = BeartypeConf(is_pep484_tower=True)  # an int where a float is asked for, as type checkers do
_DRAWS = "__beartype_getrandbits"  # an argument of what beartype makes of functions with lists
_complete: set[str] = set()


def checked(function: Callable[..., Any]) -> Callable[..., Any]:
    """The function, checking its arguments and what it returns.

    jaxtyping passes functions with an empty body. They are decorated at their first call, when the
    modules that are imported under `TYPE_CHECKING` only can be imported in fact.
    """
    made = None

    @wraps(function)
    def call(*args: Any, **kwargs: Any) -> Any:
        nonlocal made
        if made is None:
            _complete_names(function.__module__)
            made = beartype(conf=_CONF)(function)
        if _DRAWS not in made.__code__.co_varnames:
            return made(*args, **kwargs)
        state = random.getstate()  # beartype draws which items of a list it checks
        try:
            return made(*args, **kwargs)
        finally:
            random.setstate(state)

    return call


def _complete_names(module: str) -> None:
    """Gives a module the names that it imports under `TYPE_CHECKING`, as far as they are there."""
    there = sys.modules[module]
    if module in _complete or there.__file__ is None:
        return
    blocks = [
        node
        for node in ast.parse(Path(there.__file__).read_text("utf-8")).body
        if isinstance(node, ast.If) and ast.unparse(node.test) == "TYPE_CHECKING"
    ]
    missing = False
    for line in (line for block in blocks for line in block.body):
        if not isinstance(line, ast.Import | ast.ImportFrom):
            continue
        for alias in line.names:
            if isinstance(line, ast.Import):
                value = import_module(alias.name)
            else:
                value = getattr(import_module(str(line.module)), alias.name, None)
            if value is None:  # that module is being imported itself
                missing = True
            else:
                setattr(there, alias.asname or alias.name, value)
    if not missing:
        _complete.add(module)
