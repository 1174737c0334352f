"""Fixtures and hooks of all tests."""

import os
import tempfile
from collections.abc import Iterator
from importlib.util import find_spec
from pathlib import Path

import jaxtyping
import pytest

# Values are kept for all workers and the processes that tests start, not in anyone's home. Compiled
# programs are kept for the next test run too, which then takes half the time. By default, JAX keeps
# what takes a second to compile; here it keeps everything.
if "PYTEST_XDIST_WORKER" not in os.environ:
    os.environ["XDG_CACHE_HOME"] = tempfile.mkdtemp(prefix="habilis-tests-")
    os.environ["JAX_COMPILATION_CACHE_DIR"] = str(Path(__file__).parents[1] / ".pytest_cache/jax")
    os.environ["JAX_PERSISTENT_CACHE_MIN_COMPILE_TIME_SECS"] = "0"
    os.environ["JAX_PERSISTENT_CACHE_MIN_ENTRY_SIZE_BYTES"] = "-1"

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


_TESTS = Path(__file__).parent
_SLOW = {*(_TESTS / "slow.txt").read_text("utf-8").splitlines()}
"""Folders, files and tests, also with their parameters, that `make test` leaves to `test-slow`."""
_LONG = {*(_TESTS / "long.txt").read_text("utf-8").splitlines()}
"""Of these, the tests left to `make test-long`: further variants of what the others prove."""


def pytest_collection_modifyitems(items: list[pytest.Item]) -> None:
    """Marks the slow tests; lists of them are easier to keep than marks all over the files."""
    for item in items:
        test = item.nodeid.partition("[")[0]
        file = Path(test.partition("::")[0])
        if item.nodeid in _LONG:
            item.add_marker(pytest.mark.long)
        elif not _SLOW.isdisjoint({item.nodeid, test, *map(Path.as_posix, (file, *file.parents))}):
            item.add_marker(pytest.mark.slow)
