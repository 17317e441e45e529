"""Robots: a file each, with a frozen dataclass called `Robot`; adding a robot is adding a file.

A file that begins with an underscore is part of the robot it is named after: `_flow_links.py` are
FLoW's links. No robot imports another.
"""
