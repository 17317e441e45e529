"""A trial in the file formats of other tools."""

from gaitlab.render.export.export import FORMATS, Format, Recorded, write_export

__all__ = ["FORMATS", "Format", "Recorded", "write_export"]
