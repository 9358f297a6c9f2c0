"""One wheel and its quarter of the body over a rough road: equations, road shaping, linear model, what can be known."""
