"""One file a view: the steps it asks for, its layout, and what is drawn in its panels."""
