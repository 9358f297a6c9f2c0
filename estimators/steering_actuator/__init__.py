"""Monitors of an active front steering's actuator: the thesis' own and one on an identified servo model."""
