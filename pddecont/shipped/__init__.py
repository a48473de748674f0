"""Models, run files and JSON Schemas that come with the program."""
