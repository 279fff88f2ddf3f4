"""Balls under thin films, which Cycles and Lodestar both render."""

from __future__ import annotations

from typing import Any

import scenes

# Nanometers.
THICKNESSES = (150.0, 350.0, 700.0)


def ball(kind: str, thickness: float) -> Any:
    """A ball of a kind under a film, in an even world and under a lamp."""
    scene = scenes.empty()
    scenes.camera(scene, (0, -4, 1.5), (0, 0, 0), lens=60)
    scenes.world(scene, (0.5, 0.5, 0.5))
    scenes.lamp(scene, "AREA", (2, -2, 3), (0.6, 0.5, 0), energy=100, size=2.0)
    scenes.ball(scene, "ball", 1.0, scenes.material("film", lambda tree: node(tree, kind, thickness)))
    return scene


def node(tree: Any, kind: str, thickness: float) -> Any:
    """Shader under a film."""
    film = {"Thin_Film_Thickness": thickness, "Thin_Film_IOR": 1.8}
    if kind == "Metallic":
        return scenes.shader(tree, "ShaderNodeBsdfMetallic", Base_Color=(0.7, 0.6, 0.4), Edge_Tint=(1, 1, 1), Roughness=0.3, **film).outputs[0]
    if kind == "Glass":
        return scenes.shader(tree, "ShaderNodeBsdfGlass", Color=(1, 1, 1), Roughness=0.0, IOR=1.5, **film).outputs[0]
    values = {
        "dielectric": {"Base_Color": (0.02, 0.02, 0.02)},
        "dielectric with a base": {"Base_Color": (0.8, 0.5, 0.3)},
        "metal": {"Base_Color": (0.7, 0.6, 0.4), "Metallic": 1.0},
        "glass": {"Base_Color": (1, 1, 1), "Transmission_Weight": 1.0},
    }[kind]
    return scenes.shader(tree, "ShaderNodeBsdfPrincipled", Roughness=0.3, IOR=1.5, **values, **film).outputs[0]
