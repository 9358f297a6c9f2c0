"""How fast the testbed is: `python -m testbed.bench`."""
