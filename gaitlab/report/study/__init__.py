"""The report of a study: what its search found, and what was walked again to check it."""
