from .shipped import describe_shipped as describe_shipped
from .shipped import find_shipped_folders as find_shipped_folders
from .shipped import list_shipped as list_shipped
from .starters import write_starter as write_starter
