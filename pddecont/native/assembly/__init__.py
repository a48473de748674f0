"""What equations of orbits are put together with, at all their points: plain Python, compiled with the package."""
