"""``python -m pddecont``."""

from pddecont.cli import main

main()
