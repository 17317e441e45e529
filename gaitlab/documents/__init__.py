"""Files that a user writes and files that are written for one.

Read with the place of every value and checked field by field; written beside their place and
renamed. What the fields of an experiment mean is in `gaitlab.experiment`.
"""

from gaitlab.documents.fields import Reader, allowed, build, check, checked, read_each, read_mapping
from gaitlab.documents.loading import dump, inline, load, parse
from gaitlab.documents.nodes import (
    Node,
    collected,
    in_order,
    instead,
    merged,
    plain,
    typed_number,
)

__all__ = [
    "Node",
    "Reader",
    "allowed",
    "build",
    "check",
    "checked",
    "collected",
    "dump",
    "in_order",
    "inline",
    "instead",
    "load",
    "merged",
    "parse",
    "plain",
    "read_each",
    "read_mapping",
    "typed_number",
]
