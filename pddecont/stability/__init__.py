"""Floquet multipliers of periodic orbits (design section 5.3)."""
