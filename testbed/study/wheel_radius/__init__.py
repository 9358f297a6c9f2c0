"""The study `wheel-radius`: the five test runs of Persson, Gustafsson and Drevo, repeated over roads and noise."""
