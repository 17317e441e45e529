"""gaitlab tells a humanoid-robot team which gait parameters keep their robot on its feet."""

__version__ = "0.1.0"
