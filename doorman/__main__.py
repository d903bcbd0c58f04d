"""`python -m doorman`: the command line, where the script `doorman` is not on the path."""

from __future__ import annotations

import sys

from doorman.cli import main

sys.exit(main())
