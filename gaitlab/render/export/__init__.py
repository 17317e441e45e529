"""A trial in the file formats of other tools. Films of it are in `gaitlab.render`."""

from gaitlab.render.export.export import FORMATS, ExportedTrial, Format, write_export

__all__ = ["FORMATS", "ExportedTrial", "Format", "write_export"]
