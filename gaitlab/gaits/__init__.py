"""Walks as functions of time; a file each, with a frozen dataclass called `Gait`.

A gait knows its own parameters and the feet it commands, no robot and no ground. Keyframes that are
data are `motions`.
"""
