"""`python -m genus` is `genus`."""

import sys

from genus.cli.__main__ import main

if __name__ == "__main__":
    sys.exit(main())
