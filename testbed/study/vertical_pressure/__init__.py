"""Study `vertical-pressure`: tyre stiffness and pressure from hub and body accelerometers, published and at the limit."""
