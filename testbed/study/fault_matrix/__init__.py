"""Every sensor of the car with every kind of fault, all monitors of the project together."""
