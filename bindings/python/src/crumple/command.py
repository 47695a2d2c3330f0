"""The `crumple` command of the wheel: the program that the wheel contains."""

import os
import subprocess
import sys

from ._library import BINARIES

def main() -> int:
    """Runs the packed program. Returns its exit status."""
    program = os.environ.get("CRUMPLE_COMMAND") or str(BINARIES / ("crumple.exe" if os.name == "nt" else "crumple"))
    return subprocess.call([program, *sys.argv[1:]])


if __name__ == "__main__":
    sys.exit(main())
