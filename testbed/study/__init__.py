"""Studies: published experiments and standing questions, each answered by one command: a table, figures and JSON."""
