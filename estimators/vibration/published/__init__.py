"""The vibration analysis as Persson, Gustafsson, Drevo, SAE 2002-01-1250, describe it: FFT over batches, recursive
AR(2)."""
