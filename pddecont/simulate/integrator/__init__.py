"""The compiled integrator: functions of arrays and numbers that numba turns into machine code."""

import lazy_loader
import numba

from pddecont.simulate.integrator.machine_code_folder import find_machine_code

# Where a function is kept is decided when it is decorated: this comes before the other files of this folder are read.
numba.config.CACHE_DIR = str(find_machine_code())

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
