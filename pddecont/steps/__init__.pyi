from .context import Context as Context
from .kind import StepKind as StepKind
from .planning import load_run_plan as load_run_plan
from .registry import forget_step_kind as forget_step_kind
from .registry import list_step_kinds as list_step_kinds
from .registry import register_step_kind as register_step_kind
from .reporter import Reporter as Reporter
from .reporter import Silent as Silent
