"""Motions as data: keyframes of joints and feet, read from `motions/*.yaml`, tracked over time.

SI units and radians. Keys of a file:

    description: a bow                text
    tempo: 1.0                        speed of play; 2 halves every time below
    frames:                           played in order, then again from the first
      - name: stand
        move_time: 1.0                s on the way to this frame
        pause_time: 0.5               s of rest in it
        feet: {left: [0.0, 0.0385, -0.14], right: [0.0, -0.0385, -0.14], trunk_pitch: 0.1}
        joints: {waist_pitch: 0.0}
      - {name: bow, move_time: 1.0, joints: {waist_pitch: 0.5}}
      - {name: left_bow, move_time: 1.0, joints: {waist_yaw: 0.3}}
      - {name: right_bow, move_time: 1.0, mirror: left_bow}      left and right exchanged

`feet` are the points of level soles below the ankles, in the hip frame: origin midway between the
hip axes, x forward, y left, z up. What a frame does not name stays as in the frame before; the
first frame gives both feet, a level trunk and every joint that a later one moves.
"""

from gaitlab.motions.fitting import motion_problems, require_playable, static_margin
from gaitlab.motions.motion import Keyframe, Motion
from gaitlab.motions.reading import load_motion
from gaitlab.motions.track import Track

__all__ = [
    "Keyframe",
    "Motion",
    "Track",
    "load_motion",
    "motion_problems",
    "require_playable",
    "static_margin",
]
