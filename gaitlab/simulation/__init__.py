"""One trial from its numbers to its log: what a Trial is, the engine, the loop and the recording.

Only this package knows Bullet. What a robot or a gait is stands in `model`, the laws of the ground
in `surfaces`.
"""
