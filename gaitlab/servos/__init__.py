"""Servos: one YAML file each, with sources, and the law they share.

What a servo is stands in `gaitlab.model.servo`; how Bullet is made to obey the law is here.
"""
