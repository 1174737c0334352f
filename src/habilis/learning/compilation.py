"""Compiled programs, kept from one process to the next."""

import os
from pathlib import Path

import jax

_PLACE = "jax_compilation_cache_dir"


def keep_compiled() -> None:
    """Has JAX keep what it compiles on disk, unless it has been told where to already.

    In `$XDG_CACHE_HOME/habilis`, by default `~/.cache/habilis`. JAX's own settings come first:
    `JAX_COMPILATION_CACHE_DIR` names another place, `JAX_ENABLE_COMPILATION_CACHE=false` is none.
    """
    if getattr(jax.config, _PLACE) is None:
        home = os.environ.get("XDG_CACHE_HOME") or Path.home() / ".cache"
        jax.config.update(_PLACE, str(Path(home) / "habilis"))
