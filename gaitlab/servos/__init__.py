"""Servos: one YAML file each, with sources, and the law they share."""

from gaitlab.servos.servo import Servo

__all__ = ["Servo"]
