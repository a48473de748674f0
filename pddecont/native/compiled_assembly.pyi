"""The entries of the assembly as they are compiled: the functions of its sources."""

from pddecont.native.assembly.cutting import cut_piece as cut_piece
from pddecont.native.assembly.elimination import factor_in_time as factor_in_time
from pddecont.native.assembly.elimination import find_wrapped as find_wrapped
from pddecont.native.assembly.elimination import solve_bordered as solve_bordered
from pddecont.native.assembly.elimination import solve_in_time as solve_in_time
from pddecont.native.assembly.elimination import take_columns as take_columns
from pddecont.native.assembly.entries import add_moves as add_moves
from pddecont.native.assembly.entries import spread_over_reads as spread_over_reads
from pddecont.native.assembly.entries import spread_slopes as spread_slopes
from pddecont.native.assembly.entries import stretch_moves as stretch_moves
from pddecont.native.assembly.extrema import choose_extrema as choose_extrema
from pddecont.native.assembly.lagged import move_lagged_reads as move_lagged_reads
from pddecont.native.assembly.lagged import stretch_lagged_rates as stretch_lagged_rates
from pddecont.native.assembly.lagrange import evaluate_lagrange as evaluate_lagrange
from pddecont.native.assembly.location import locate_times as locate_times
from pddecont.native.assembly.reading import move_reads as move_reads
from pddecont.native.assembly.reading import read_states as read_states
from pddecont.native.assembly.reading import weigh_reads as weigh_reads
from pddecont.native.assembly.reading import weigh_values as weigh_values
from pddecont.native.assembly.residual import fill_residual as fill_residual
from pddecont.native.assembly.sparse import add_up as add_up
from pddecont.native.assembly.sparse import append_row as append_row
from pddecont.native.assembly.sparse import scale_to_one as scale_to_one
from pddecont.native.assembly.sparse import sort_entries as sort_entries
from pddecont.native.assembly.transfer import transfer_values as transfer_values
from pddecont.native.assembly.turning import find_turns as find_turns

DIGEST: str
