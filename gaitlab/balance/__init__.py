"""Controllers that close the loop from an IMU to the joints; a file each.

A file holds a frozen dataclass called `Balance`, see `gaitlab.model.balance`; what an IMU measures
is in `gaitlab.model.imu`.
"""
