"""The notebooks: light, without outputs in the repository, and what they say holds."""

import json
import re
from pathlib import Path

import nbformat
import notebooks
import pytest
from mkdocs.exceptions import PluginError
from nbclient import NotebookClient

ROOT = Path(__file__).parents[1]
NOTEBOOKS = sorted((ROOT / "examples" / "notebooks").glob("*.ipynb"))
LARGEST = 20_000  # bytes


def name(path):
    return path.stem


def sources(notebook, kind):
    return [cell.source for cell in notebook.cells if cell.cell_type == kind]


def test_there_are_five():
    assert [path.stem for path in NOTEBOOKS] == [
        *("comparing-tools", "pushworld", "ten-minutes", "training-with-a-bonus"),
        "your-own-model",
    ]


@pytest.mark.parametrize("path", NOTEBOOKS, ids=name)
def test_a_notebook_has_no_outputs_and_is_light(path):
    text = path.read_text("utf-8")
    assert len(text) < LARGEST
    assert text.endswith("}\n")
    notebook = json.loads(text)
    for cell in notebook["cells"]:
        if cell["cell_type"] == "code":
            assert cell["outputs"] == []
            assert cell["execution_count"] is None
        assert set(cell["metadata"]) <= {"alt"}
    assert set(notebook["metadata"]) == {"kernelspec", "language_info"}
    nbformat.validate(notebook)


@pytest.mark.parametrize("path", NOTEBOOKS, ids=name)
def test_a_notebook_has_a_title_checks_its_numbers_and_leads_on(path):
    notebook = nbformat.read(path, 4)
    texts, code = sources(notebook, "markdown"), "\n".join(sources(notebook, "code"))
    assert re.match(r"# \S", texts[0])
    assert [text for text in texts[1:] if re.match(r"# ", text)] == []
    assert len(re.findall(r"^ *assert ", code, re.MULTILINE)) >= 3
    links = re.findall(r"\]\((?!https:)([^)#]+)\)", "\n".join(texts))
    assert links
    for link in links:
        assert (path.parent / link).exists(), link


def test_every_notebook_is_in_the_navigation():
    navigation = re.findall(r"notebooks/([\w-]+)\.md", (ROOT / "mkdocs.yml").read_text("utf-8"))
    assert sorted(navigation) == [path.stem for path in NOTEBOOKS]


@pytest.mark.parametrize("path", NOTEBOOKS, ids=name)
def test_a_notebook_runs_and_what_it_says_holds(path, tmp_path):
    notebook = nbformat.read(path, 4)
    where = {"metadata": {"path": str(tmp_path)}}
    NotebookClient(notebook, timeout=120, kernel_name="python3", resources=where).execute()
    outputs = [output for cell in notebook.cells for output in cell.get("outputs", ())]
    assert [output for output in outputs if output.get("name") == "stderr"] == []
    assert [output for output in outputs if "image/svg+xml" in output.get("data", {})] or (
        path.stem == "your-own-model"  # which has no map
    )
    assert list(tmp_path.iterdir()) == []  # nothing is left behind


def code_cell(*outputs, **metadata):
    cell = nbformat.v4.new_code_cell("x = 1", metadata=metadata)
    cell.outputs = list(outputs)
    return cell


def shown(**data):
    return nbformat.v4.new_output("execute_result", data)


def test_a_page_has_what_cells_show_and_links_of_its_own():
    words = "# One\n\n[a](../../docs/how-to/studio.md#x), [b](pushworld.ipynb), [c](https://x.org)"
    svg = {"image/svg+xml": "<svg/>", "text/plain": "<World x: 1>"}
    notebook = nbformat.v4.new_notebook(
        cells=[
            nbformat.v4.new_markdown_cell(words),
            code_cell(shown(**svg), nbformat.v4.new_output("stream", text="said\n")),
            code_cell(shown(**{"text/html": "<b>1</b>\n\n<i>2</i>", "text/plain": "no"})),
            code_cell(
                shown(**{"image/png": "AAAA", "text/plain": "<Figure 1>"}), alt='A "red" cell'
            ),
            code_cell(shown(**{"text/plain": "42"})),
        ]
    )
    *files, (page, text) = notebooks.page_of(notebook, "one")
    assert isinstance(text, str)
    assert files == [("one-1.svg", "<svg/>"), ("one-2.png", b"\0\0\0")]
    assert page == "one.md"
    assert "[a](../how-to/studio.md#x), [b](pushworld.md), [c](https://x.org)" in text
    assert '<img alt="&lt;World x: 1&gt;" src="one-1.svg">' in text
    assert '<img alt="A &quot;red&quot; cell" src="one-2.png">' in text
    assert '<div class="shown" markdown="0"><b>1</b>\n<i>2</i></div>' in text
    assert "```text\nsaid\n```" in text
    assert "```text\n42\n```" in text
    assert "no" not in text.split()
    assert "(one.ipynb)" in text


def test_the_build_refuses_a_warning_an_error_and_a_picture_without_words():
    figure = shown(**{"image/png": "AAAA", "text/plain": "<Figure 1>"})
    warning = nbformat.v4.new_output("stream", name="stderr", text="old")
    for output, problem in (
        (figure, 'needs a description, metadata "alt"'),
        (warning, "stderr: old"),
    ):
        with pytest.raises(PluginError, match=problem):
            notebooks.page_of(nbformat.v4.new_notebook(cells=[code_cell(output)]), "one")
    failing = nbformat.v4.new_notebook(cells=[nbformat.v4.new_code_cell("1 / 0")])
    with pytest.raises(PluginError, match=r"(?s)one.ipynb: .*ZeroDivisionError"):
        notebooks.executed(failing, "one.ipynb")
