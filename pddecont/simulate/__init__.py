"""Trajectories: integration with events and resets, and what period they settle to."""
