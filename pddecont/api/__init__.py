"""The Python interface, which the command line is built on: a run as a function, its results as arrays and data sets.

>>> import pddecont
>>> results = pddecont.run("wright", mesh={"degree": 4, "tol": 1e-4}, only="transient")
>>> list(results)
['transient']
>>> results["transient"].arrays()["x"].ndim
1
"""

import lazy_loader

__getattr__, __dir__, __all__ = lazy_loader.attach_stub(__name__, __file__)
