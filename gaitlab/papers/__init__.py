"""Everything that knows a paper: its printed tables and mistakes, its audit, its reproduction.

What any team could set beside its results is no paper's and belongs to `experiment.reference`; what
is true of a robot belongs to the robot.
"""
