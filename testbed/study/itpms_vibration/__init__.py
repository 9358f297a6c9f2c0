"""Study `itpms-vibration`: the vibration analysis of Persson, Gustafsson, Drevo, SAE 2002-01-1250."""
