"""One BLAS thread for every test, set before numpy is loaded.

The number of threads may decide the last bit of a matrix product. Tests train in this process and compare
with what the command writes, whose processes have one thread each whatever the variable says.
"""

from __future__ import annotations

import os

os.environ["OPENBLAS_NUM_THREADS"] = "1"
