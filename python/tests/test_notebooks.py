"""Every notebook runs to its end and shows pictures."""

import base64
import os
import pathlib

import nbformat
import pytest
from nbclient import NotebookClient

FOLDER = pathlib.Path(__file__).resolve().parents[1] / "notebooks"
NOTEBOOKS = ["first_picture", "guided_against_plain", "lamp_sweep", "what_the_guide_learned"]


def test_no_notebook_is_forgotten():
    assert sorted(path.stem for path in FOLDER.glob("*.ipynb")) == NOTEBOOKS


@pytest.mark.parametrize("name", NOTEBOOKS)
def test_a_notebook_runs(name, tmp_path):
    notebook = nbformat.read(FOLDER / f"{name}.ipynb", as_version=4)
    assert all(not cell.get("outputs") for cell in notebook.cells), "clear the outputs"
    NotebookClient(notebook, timeout=600, resources={"metadata": {"path": tmp_path}}).execute()
    outputs = [output for cell in notebook.cells for output in cell.get("outputs", [])]
    assert all(output.get("name") != "stderr" for output in outputs), "a notebook gives no warning"
    pictures = [output.data["image/png"] for output in outputs if "image/png" in output.get("data", {})]
    assert pictures
    # For people who look at them.
    folder = os.environ.get("LODESTAR_NOTEBOOK_PICTURES")
    for at, picture in enumerate(pictures if folder else []):
        (pathlib.Path(folder) / f"{name}-{at}.png").write_bytes(base64.b64decode(picture))
