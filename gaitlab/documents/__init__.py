"""Files that a user writes: read with the place of every value, checked field by field."""

from gaitlab.documents.fields import allowed, build, check, checked, parameter_table
from gaitlab.documents.nodes import Node, dump, load, merged, parse, plain

__all__ = [
    "Node",
    "allowed",
    "build",
    "check",
    "checked",
    "dump",
    "load",
    "merged",
    "parameter_table",
    "parse",
    "plain",
]
