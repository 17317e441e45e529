"""Searching a study for the parameters that walk best, and checking the winner.

Here belongs what asks for candidates, races them, keeps the record of a search and walks its
winner again. Only this folder knows Optuna; what a file may ask for is read in
`gaitlab.experiment`, pages are written in `gaitlab.report`.
"""

from gaitlab.search.candidates import Candidate, History

__all__ = ["Candidate", "History"]
