from .curve import TOGETHER as TOGETHER
from .curve import Curve as Curve
from .elimination import Blocks as Blocks
from .elimination import Border as Border
from .residual import Equations as Equations
from .turning import MAX_HALVINGS as MAX_HALVINGS
