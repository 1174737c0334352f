"""Compiled programs, kept from one process to the next."""

from pathlib import Path

import jax

from habilis.cache import cache_folder
from habilis.files import check_folder

_PLACE = "jax_compilation_cache_dir"


def keep_compiled() -> None:
    """Has JAX keep what it compiles on disk, unless it has been told where to already.

    In `$XDG_CACHE_HOME/habilis`, by default `~/.cache/habilis`. JAX's own settings come first:
    `JAX_COMPILATION_CACHE_DIR` names another place, `JAX_ENABLE_COMPILATION_CACHE=false` is none.
    """
    folder = cache_folder()
    if getattr(jax.config, _PLACE) is None and folder is not None and _can_be_written(folder):
        jax.config.update(_PLACE, str(folder))


def _can_be_written(folder: Path) -> bool:
    """Where it cannot, JAX would warn of every program."""
    try:
        check_folder(folder)
    except ValueError:
        return False
    return True
