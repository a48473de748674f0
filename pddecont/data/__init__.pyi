from .message_index import Entry as Entry
from .message_index import explain_message as explain_message
from .message_index import read_entries as read_entries
from .message_index import tells as tells
from .shipped import describe_shipped as describe_shipped
from .shipped import find_shipped_folders as find_shipped_folders
from .shipped import list_shipped as list_shipped
from .starters import write_starter as write_starter
