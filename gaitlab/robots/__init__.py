"""Robots: a file each, with a frozen dataclass called `Robot`; adding a robot is adding a file.

Its geometry is parameters, its links are rows of the CSV file beside it. No robot imports another.
"""
