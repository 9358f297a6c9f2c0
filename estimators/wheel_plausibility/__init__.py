"""Are the four wheel speeds those of the car? Erroneous sensors and wheels that slip (seed 004, chapter 6)."""
