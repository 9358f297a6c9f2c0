"""Study `itpms-fusion`: tyre pressure without a pressure sensor, judged over hundreds of drives."""
