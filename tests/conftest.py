"""Settings of all tests."""

from __future__ import annotations

import os

from hypothesis import settings

# Several processes of tests fill the cores: threads of BLAS would only wait for each other. It is asked for
# before anything imports NumPy; programs that tests start inherit it.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

# A busy machine exceeds any time limit for an example, and a failure that comes from new random examples
# cannot be repeated: no limit, and the same examples in every run. For many more of them, run pytest
# with --hypothesis-profile=thorough.
settings.register_profile("vibro", deadline=None, derandomize=True, database=None, max_examples=40)
settings.register_profile("thorough", settings.get_profile("vibro"), max_examples=1000)
settings.load_profile("vibro")
