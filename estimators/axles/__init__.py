"""Tyre stiffness from both axles: the rear wheel meets the front wheel's road one wheelbase later."""
