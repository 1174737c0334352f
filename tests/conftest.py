"""What all tests share."""

import os
import tempfile

# Compiled programs are kept for the processes that tests start, and not in anyone's home.
os.environ["JAX_COMPILATION_CACHE_DIR"] = tempfile.mkdtemp(prefix="habilis-tests-")
