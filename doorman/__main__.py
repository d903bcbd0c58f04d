"""`python -m doorman`: the command line, where the script `doorman` is not on the path."""

from __future__ import annotations

from doorman.cli import main

main()
