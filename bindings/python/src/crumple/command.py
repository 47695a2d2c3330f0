"""The `crumple` command of the wheel: the program that the wheel contains, and `examples`, which is written in Python."""

import os
import subprocess
import sys

from ._library import BINARIES

_HELP = """
Of the Python package:
  examples  Make examples for a bare mesh, with a solver or with --profile
"""


def main() -> int:
    """Runs `examples` here and every other subcommand in the packed program. Returns the exit status."""
    arguments = sys.argv[1:]
    if arguments[:1] == ["examples"]:
        from .examples.command import main as examples

        return examples(arguments[1:])
    program = os.environ.get("CRUMPLE_COMMAND") or str(BINARIES / ("crumple.exe" if os.name == "nt" else "crumple"))
    status = subprocess.call([program, *arguments])
    if arguments in ([], ["help"], ["-h"], ["--help"]):
        print(_HELP, end="", flush=True)
    return status


if __name__ == "__main__":
    sys.exit(main())
