# Nothing is called that is not in the modules of this folder.
