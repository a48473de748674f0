from .ending import report_done as report_done
from .run import execute as execute
from .units import find_units as find_units
