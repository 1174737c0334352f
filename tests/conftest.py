"""What all tests share."""

import os
import tempfile
from importlib.util import find_spec

# Values and compiled programs are kept for the processes that tests start, not in anyone's home.
_CACHE = tempfile.mkdtemp(prefix="habilis-tests-")
os.environ["JAX_COMPILATION_CACHE_DIR"] = _CACHE
os.environ["XDG_CACHE_HOME"] = _CACHE

# Those with other people's agents are for an environment of their own: make test-integration.
_APART = ("torch", "stable_baselines3", "gymnax")
collect_ignore = [] if all(map(find_spec, _APART)) else ["integration"]
