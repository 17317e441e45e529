"""The figures of a report, one file each; they draw what they are given and choose nothing."""

from gaitlab.picture.figure_style import DARK

__all__ = ["DARK"]
