"""Active front steering: superposition gear, variable ratio, motor, its control and its lock."""
