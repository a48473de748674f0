from .diagnosis import find_non_finite as find_non_finite
from .machine_code import ModelFunctions as ModelFunctions
from .machine_code import write_rule as write_rule
from .numeric_model import NumericModel as NumericModel
from .numeric_model import ParameterFunction as ParameterFunction
from .numpy_backend import ArrayFunction as ArrayFunction
from .numpy_backend import Derivatives as Derivatives
from .numpy_backend import Structure as Structure
