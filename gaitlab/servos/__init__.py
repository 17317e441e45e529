"""Servos: one YAML file each, with sources, and the law they share."""
