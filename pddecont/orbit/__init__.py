"""The multi-segment boundary-value problem that a periodic orbit solves (design section 5)."""
