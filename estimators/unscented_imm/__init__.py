"""Tyre stiffness from body and hub acceleration by unscented filters of a nonlinear quarter car, one a road class."""
