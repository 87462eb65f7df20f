"""Puts this folder on the path, so that tests share the generators of truth that stand in it."""

import os

# As the command line does: threads of BLAS cost more than they give on small matrices, most of all side by side.
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
