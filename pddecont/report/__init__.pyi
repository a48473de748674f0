from .page import Live as Live
from .page import Picture as Picture
from .page import draw_picture as draw_picture
from .page import is_page as is_page
from .page import make_environment as make_environment
from .page import render_page as render_page
from .step_tables import format_value as format_value
