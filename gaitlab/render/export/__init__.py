"""A trial in the file formats of other tools, a module for each that needs one.

Here belongs what those tools read; what only gaitlab reads is in `gaitlab.store`.
"""

from gaitlab.render.export.export import FORMATS, ExportedTrial, Format, write_export

__all__ = ["FORMATS", "ExportedTrial", "Format", "write_export"]
