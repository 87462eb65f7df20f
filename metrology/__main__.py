"""`python -m metrology`."""

import sys

from metrology.cli import main

sys.exit(main())
