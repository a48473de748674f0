from .page import render_page as render_page
