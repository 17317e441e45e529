"""Geometry and dynamics as the papers print them: functions of numbers, with equation numbers.

No robot, no log and no file is known here; a robot's lengths stand with the robot.
"""
