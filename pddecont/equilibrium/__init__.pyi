from .characteristic import CharacteristicMatrix as CharacteristicMatrix
from .constant_motion import ConstantMotion as ConstantMotion
from .hopf import HopfPoint as HopfPoint
from .hopf import HopfProblem as HopfProblem
from .hopf import solve_hopf as solve_hopf
