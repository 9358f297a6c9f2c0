"""Tyre stiffness and pressure from hub acceleration: a bank of linear filters over stiffness and road level."""
