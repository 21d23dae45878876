"""Imports bpy with fixes: Blender 3.4 of Debian 12 runs with a newer Python and numpy than it was written for."""
import builtins

import numpy

plain_open = builtins.open
builtins.open = lambda file, mode="r", *a, **k: plain_open(file, mode.replace("U", "") or "r", *a, **k)
for name, kind in (("bool", bool), ("object", object), ("int", int), ("float", float)):
    if name not in numpy.__dict__:
        setattr(numpy, name, kind)

import bpy  # noqa: E402, F401
