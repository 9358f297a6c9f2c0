"""Tyre stiffness and pressure from body and hub acceleration: a bank of linear filters over stiffness and road level."""
