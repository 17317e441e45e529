"""A paper's findings predicted anew: several experiments whose results share one page."""
