from .fragments import render_facts as render_facts
from .fragments import render_results as render_results
from .fragments import render_rows as render_rows
from .fragments import render_step as render_step
from .progress import NotebookProgress as NotebookProgress
from .progress import choose_reporter as choose_reporter
