"""A page that shows packings, modes and waves in a browser, in one file that needs no network.

    sonopack.view.page({"P.h5": packing}, "P.html")
"""
from ._data import Choice
from ._page import page

__all__ = ["Choice", "page"]
