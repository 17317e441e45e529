"""Files that a user writes: read with the place of every value, checked field by field."""

from gaitlab.documents.fields import build, check, checked
from gaitlab.documents.loading import dump, load, parse
from gaitlab.documents.messages import allowed
from gaitlab.documents.mistakes import collected, in_order
from gaitlab.documents.nodes import Node, merged, plain
from gaitlab.documents.typed import instead, typed_number

__all__ = [
    "Node",
    "allowed",
    "build",
    "check",
    "checked",
    "collected",
    "dump",
    "in_order",
    "instead",
    "load",
    "merged",
    "parse",
    "plain",
    "typed_number",
]
