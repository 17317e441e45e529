"""A robot on its ground as polygons, for reports and films alike."""
