"""Searching a study for the parameters that walk best, and checking what was found."""
