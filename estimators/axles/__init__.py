"""Tyre stiffness from both axles over the same road: the rear wheel meets the front wheel's road one wheelbase later."""
