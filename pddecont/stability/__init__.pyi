from .multipliers import OUTSIDE as OUTSIDE
from .multipliers import TRIVIAL_ERROR as TRIVIAL_ERROR
from .multipliers import MultiplierCache as MultiplierCache
from .multipliers import Multipliers as Multipliers
from .multipliers import find_eigenvector as find_eigenvector
from .multipliers import find_multipliers as find_multipliers
from .multipliers import remove_known as remove_known
