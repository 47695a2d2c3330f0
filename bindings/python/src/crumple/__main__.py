"""`python -m crumple` is the `crumple` command."""

import sys

from .command import main

sys.exit(main())
