"""`python -m bath_drake`: the command line."""

import sys

from bath_drake.cli import main

if __name__ == "__main__":
    sys.exit(main())
