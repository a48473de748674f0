"""One page on a results file: pictures, tables, settings, versions."""
