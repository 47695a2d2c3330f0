"""`crumple examples`: makes the examples of a bare mesh with a solver, or generic ones without."""


class Failure(Exception):
    """Examples could not be made. The text says why and what to change."""
