"""The page of a study: what its search found, and what was walked again. Racing and validation are
in `gaitlab.search`.
"""
