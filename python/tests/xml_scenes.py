"""A second reader of Mitsuba's XML, to dictionaries. It knows what the repository's scenes have, and no more."""

import pathlib
import xml.etree.ElementTree as tree

import lodestar

OBJECTS = {"bsdf", "emitter", "film", "integrator", "rfilter", "sampler", "sensor", "shape", "texture"}


def numbers(text):
    return [float(word) for word in text.replace(",", " ").split()]


def vector(node, default):
    if "value" in node.attrib:
        values = numbers(node.get("value"))
        return values * 3 if len(values) == 1 else values
    return [float(node.get(axis, default)) for axis in "xyz"]


def transform(node):
    result = lodestar.ScalarTransform4f()
    for operation in node:
        one = lodestar.ScalarTransform4f()
        match operation.tag:
            case "translate":
                step = one.translate(vector(operation, 0.0))
            case "scale":
                step = one.scale(vector(operation, 1.0))
            case "rotate":
                step = one.rotate(vector(operation, 0.0), float(operation.get("angle")))
            case "lookat":
                step = one.look_at(*(numbers(operation.get(name)) for name in ("origin", "target", "up")))
            case "matrix":
                values = numbers(operation.get("value"))
                step = lodestar.ScalarTransform4f([values[i : i + 4] for i in range(0, 16, 4)])
            case other:
                raise NotImplementedError(other)
        result = step @ result
    return result


class Reader:
    def __init__(self, path, parameters):
        self.folder = pathlib.Path(path).parent
        self.parameters = parameters
        self.unnamed = 0

    def scene(self, path):
        result = {"type": "scene"}
        self.children(self.parse(path), result)
        return result

    def parse(self, path):
        return tree.parse(path).getroot()

    def substituted(self, node):
        for inner in node.iter():
            for name, text in inner.attrib.items():
                for key, value in self.parameters.items():
                    text = text.replace(f"${key}", value)
                inner.set(name, text)
        return node

    def children(self, node, into):
        for child in node:
            self.add(self.substituted(child), into)

    def add(self, node, into):
        match node.tag:
            case "default":
                self.parameters.setdefault(node.get("name"), node.get("value"))
                return
            case "include":
                root = self.parse(self.folder / node.get("filename"))
                self.children(root, into)
                return
        key = node.get("id") or node.get("name")
        if key is None:
            key, self.unnamed = f"unnamed_{self.unnamed}", self.unnamed + 1
        into[key] = self.value(node)

    def value(self, node):
        text = node.get("value")
        match node.tag:
            case "float":
                return float(text)
            case "integer":
                return int(text)
            case "boolean":
                return text.strip().lower() == "true"
            case "string" if node.get("name") == "filename":
                return self.folder / text
            case "string":
                return text
            case "point" | "vector":
                return vector(node, 0.0)
            case "rgb":
                return {"type": "rgb", "value": text if text.startswith("#") else numbers(text)}
            case "spectrum" if "type" not in node.attrib and ":" not in text:
                return {"type": "spectrum", "value": numbers(text)}
            case "spectrum" if "type" not in node.attrib:
                pairs = [tuple(map(float, pair.split(":"))) for pair in text.replace(",", " ").split()]
                return {"type": "spectrum", "value": pairs}
            case "transform":
                return transform(node)
            case "ref":
                return {"type": "ref", "id": node.get("id")}
            case tag if tag in OBJECTS:
                result = {"type": node.get("type")}
                if "id" in node.attrib:
                    result["id"] = node.get("id")
                self.children(node, result)
                return result
            case other:
                raise NotImplementedError(other)


def as_dictionary(path, **defines):
    """The scene of an XML file as a dictionary."""
    return Reader(path, defines).scene(path)
