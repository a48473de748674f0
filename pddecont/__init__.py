"""Bifurcation analysis of piecewise-smooth delay differential equations."""

__version__ = "0.1.0"
