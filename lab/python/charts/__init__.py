"""One module a part of the lab: `draw(directory)` reads its tables there and leaves its charts beside them."""
