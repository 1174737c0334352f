"""Fixtures and hooks of all tests."""

import os
import tempfile
from collections.abc import Iterator
from importlib.util import find_spec

import jaxtyping
import pytest

# Values and compiled programs are kept for the processes that tests start, not in anyone's home.
_CACHE = tempfile.mkdtemp(prefix="habilis-tests-")
os.environ["JAX_COMPILATION_CACHE_DIR"] = _CACHE
os.environ["XDG_CACHE_HOME"] = _CACHE

# Those with other people's agents are for an environment of their own: make test-integration.
_APART = ("torch", "stable_baselines3", "gymnax")
_IS_APART = all(map(find_spec, _APART))
collect_ignore = [] if _IS_APART else ["integration"]

if not _IS_APART:  # other people's code may let JAX extend shapes; ours says where it does
    os.environ["JAX_NUMPY_RANK_PROMOTION"] = "raise"


@pytest.fixture(autouse=True)
def _annotations_are_checked(request: pytest.FixtureRequest) -> Iterator[None]:
    """At run time, but for tests of what is refused that no type checker would let pass."""
    jaxtyping.config.update(
        "jaxtyping_disable", request.node.get_closest_marker("ill_typed") is not None
    )
    yield
    jaxtyping.config.update("jaxtyping_disable", False)
