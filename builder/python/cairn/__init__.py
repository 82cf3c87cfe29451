"""Terrain packs of cairn: heights and imagery as numpy arrays, and bakes.

>>> import cairn
>>> pack = cairn.open("alps.cairn")
>>> pack.heights([8.1, 8.2], 46.5).metres
"""

import collections

from cairn._cairn import BadDataError, Cancelled, Error, Pack, UsageError, __version__, bake, open

Heights = collections.namedtuple("Heights", ("metres", "level", "error_m"))
Heights.__doc__ = "Heights at places: metres, the level of the tile that gave each, and the geometric error of that tile."

__all__ = ["BadDataError", "Cancelled", "Error", "Heights", "Pack", "UsageError", "bake", "open"]
