"""Study `vertical-pressure`: tyre pressure from hub and body accelerometers, as published and at the limit."""
