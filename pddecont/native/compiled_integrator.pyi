"""The integrator's entries as they are compiled: the functions of its sources."""

from pddecont.native.integrator.advance import change_parameters as change_parameters
from pddecont.native.integrator.advance import initialise as initialise
from pddecont.native.integrator.advance import run as run
from pddecont.native.integrator.poincare import advance_to_return as advance_to_return
from pddecont.native.integrator.poincare import follow_to_period as follow_to_period
from pddecont.native.integrator.restart import begin_inside_arc as begin_inside_arc
from pddecont.native.integrator.tangent_growth import measure_growth as measure_growth

DIGEST: str
