"""A robot of anybody's, from its URDF: what it consists of, its legs and soles, how it stands.

Here belongs what is found in a file that nobody wrote for gaitlab, by geometry and never by names;
a robot whose numbers are known in advance is a file in `gaitlab/robots` instead.
"""
