"""What all tests share."""

import os
import tempfile

# Values and compiled programs are kept for the processes that tests start, not in anyone's home.
_CACHE = tempfile.mkdtemp(prefix="habilis-tests-")
os.environ["JAX_COMPILATION_CACHE_DIR"] = _CACHE
os.environ["XDG_CACHE_HOME"] = _CACHE
