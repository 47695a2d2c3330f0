"""Draws every chart whose tables are there: `draw.py DIRECTORY`. Each module of `charts` has a function `draw(directory)`."""

import importlib
import pkgutil
import sys

import charts

if __name__ == "__main__":
    for module in sorted(m.name for m in pkgutil.iter_modules(charts.__path__)):
        importlib.import_module(f"charts.{module}").draw(sys.argv[1])
