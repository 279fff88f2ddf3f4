"""What the installed package holds besides its code."""

import importlib.metadata


def test_the_licenses_of_what_is_linked_are_there():
    files = importlib.metadata.files("lodestar-render")
    texts = {file.name: file.read_text() for file in files if "licenses" in file.parts}
    assert {"LICENSE-APACHE", "LICENSE-MIT", "LICENSES-OF-DEPENDENCIES.txt"} <= texts.keys()
    linked = texts["LICENSES-OF-DEPENDENCIES.txt"]
    for crate in ("ash ", "exr ", "gpu-allocator ", "numpy ", "pyo3 ", "rayon "):
        assert f"\n{crate}" in f"\n{linked}", crate
    assert "Permission is hereby granted" in linked and "Apache License" in linked
