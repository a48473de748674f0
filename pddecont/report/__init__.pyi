from .page import Live as Live
from .page import is_page as is_page
from .page import render_page as render_page
