"""Smallest scene in which a difference stays: parts are left out, or replaced by plain ones, one after the other."""

import copy
import xml.etree.ElementTree as ElementTree

# Modifiers that a BSDF in them can replace.
WRAPPERS = ("twosided", "mask", "blendbsdf", "bumpmap", "normalmap")


def steps(root):
    """Smaller scenes, the largest steps first. Each is a function that changes a copy of `root`; parts are named by their places."""
    elements = list(root.iter())
    parents = {id(child): at for at, parent in enumerate(elements) for child in parent}
    kept = ("scene", "integrator", "sensor", "film", "rfilter", "width", "height")

    def without(at):
        def change(scene):
            every = list(scene.iter())
            every[parents[id(elements[at])]].remove(every[at])

        return change

    def put(at, made):
        def change(scene):
            every = list(scene.iter())
            parent = every[parents[id(elements[at])]]
            new = made(every[at])
            if every[at].get("name"):
                new.set("name", every[at].get("name"))
            parent[list(parent).index(every[at])] = new

        return change

    removable = [at for at, element in enumerate(elements) if element.tag in ("shape", "emitter") and element.get("type") != "shapegroup"]
    yield from (without(at) for at in removable)
    for at, element in enumerate(elements):
        if element.tag == "bsdf" and element.get("type") in WRAPPERS:
            for inner in [index for index, child in enumerate(element) if child.tag == "bsdf"]:
                yield put(at, lambda found, inner=inner: copy.deepcopy(found[inner]))
        if element.tag == "bsdf" and element.get("type") not in (*WRAPPERS, "diffuse"):
            yield put(at, lambda _: ElementTree.Element("bsdf", {"type": "diffuse"}))
        if element.tag == "texture" and element.get("name"):
            yield put(at, lambda _: ElementTree.Element("rgb", {"value": "0.5"}))
    for at, element in enumerate(elements):
        parent = elements[parents[id(element)]] if id(element) in parents else None
        is_free = parent is not None and element.tag not in kept and element.get("name") not in ("filename", "width", "height", "pixel_format")
        if is_free and element.tag not in ("shape", "bsdf", "emitter", "lookat"):
            yield without(at)


def shrink(root, stays, tries=60):
    """Smallest scene found for which `stays` holds, after that many tries."""
    best, left = root, tries
    while left > 0:
        for change in steps(best):
            if left <= 0:
                break
            smaller = copy.deepcopy(best)
            change(smaller)
            left -= 1
            if stays(smaller):
                best = smaller
                break
        else:
            break
    return best
