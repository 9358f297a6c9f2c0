"""Methods that tell tyre pressure and sensor health from a car's own signals, and the drive log they read."""
