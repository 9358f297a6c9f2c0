"""Models of the default car that estimators start from, identified on drives at known pressures."""
