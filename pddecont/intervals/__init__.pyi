from .enclosure import Enclosure as Enclosure
from .zeros import BUDGET as BUDGET
from .zeros import Zeros as Zeros
from .zeros import find_zeros as find_zeros
