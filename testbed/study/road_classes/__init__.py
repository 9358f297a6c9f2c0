"""The study `road-classes`: what the car does on every road class, against what it is known to do."""
