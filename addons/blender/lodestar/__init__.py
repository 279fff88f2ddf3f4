"""Lodestar as a render engine of Blender."""

from . import engine, panels, properties

MODULES = (properties, engine, panels)


def register() -> None:
    """Adds the engine, its settings and its panels to Blender."""
    for module in MODULES:
        module.register()


def unregister() -> None:
    """Takes everything away that `register` added."""
    for module in reversed(MODULES):
        module.unregister()
