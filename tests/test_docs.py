"""The documentation: its code runs, it builds, and the reference lacks nothing."""

import os
import re
import subprocess
import sys
from pathlib import Path

import blocks
import environments
import pytest
import reference
from playwright.sync_api import sync_playwright
from studio_page import CHROMIUM, OPTIONS

import habilis
from habilis.worlds import two_agents
from habilis.worlds.placements import start_of
from habilis.worlds.table import placement

ROOT = Path(__file__).parents[1]
PAGES = [ROOT / "README.md", *sorted((ROOT / "docs").rglob("*.md"))]
WITH_CODE = [page for page in PAGES if any(b.runs for b in blocks.blocks(page.read_text("utf-8")))]


def name(page):
    return str(page.relative_to(ROOT))


@pytest.mark.parametrize("page", WITH_CODE, ids=name)
def test_the_code_of_a_page_runs_and_prints_what_it_says(page, tmp_path):
    blocks.run(page, tmp_path)


@pytest.mark.parametrize("page", PAGES, ids=name)
def test_commands_that_are_not_run_are_commands(page):
    from habilis.cli import parser

    targets = re.findall(r"^([\w-]+):", (ROOT / "Makefile").read_text("utf-8"), re.MULTILINE)
    for block in blocks.blocks(page.read_text("utf-8")):
        if block.language == "sh":
            for line, words in blocks.commands(block):
                if words[0] == "habilis":
                    parser().parse_args(words[1:])
                elif words[0] == "make":
                    assert set(words[1:]) <= set(targets), f"{page.name}, line {line}"
                else:
                    assert block.not_run, f"{page.name}, line {line}: {words[0]}"


def drawings():
    """Each drawing of the rules and of the tools: the map before, the action, the map after."""
    tools = (ROOT / "docs" / "reference" / "tools.md").read_text("utf-8")
    for before, action, after in re.findall(r"`(\S*A\S*)` \| ([a-z ]+) \| `(\S+)` \|", tools):
        yield [before], action, [after]
    page = (ROOT / "docs" / "explanation" / "rules.md").read_text("utf-8")
    for block in blocks.blocks(page):
        for drawing in block.text.strip("\n").split("\n\n"):
            parts = [re.split(r"\s{2,}", line) for line in drawing.splitlines()]
            (action,) = (part[1] for part in parts if len(part) == 3)
            yield [part[0] for part in parts], action, [part[-1] for part in parts]


KINDS = {"R": "rake", "S": "stick", "M": "magnet", "D": "ball", "E": "crate"}


OF_TWO = {"E": "agent", "D": "door", "O": "open door", "C": "crate"}


def drawn(rows, actions, words=""):
    """A drawing as a world. It has no goal: one is put where nothing comes to."""
    cells = "".join(rows)
    if "+" in "".join(actions):  # of two agents
        above = [f"{one} = {kind}" for one, kind in OF_TWO.items() if one in cells]
        return habilis.World.parse("\n".join([*above, *rows]))
    first = next((character for character in cells if character in "CDE"), "")
    above = [f"{character} = {kind}" for character, kind in KINDS.items() if character in cells]
    above += [f"P = picker {words}"] if words else []
    below = ["#" * len(rows[0]), "G".ljust(len(rows[0]), "#")]
    if not first:
        below[0], first = "C".ljust(len(rows[0]), "#"), "C"
    drop = "drop: true" if "drop" in actions else ""
    return habilis.World.parse("\n".join([*above, f"G = goal of {first}", drop, *rows, *below]))


@pytest.mark.parametrize(("before", "action", "after"), list(drawings()))
def test_the_drawings_of_rules_and_tools_are_what_happens(before, action, after):
    words, _, action = action.rpartition(": ")
    actions = action.split(", ")
    world = drawn(before, actions, words)
    mdp = habilis.tabulate(world, starts=[placement_of(world)])
    state = mdp.start
    for one in actions:
        state = mdp.next_state[state, mdp.actions.index(one)]
    assert placement_of(placement(world, mdp, state)) == placement_of(drawn(after, actions, words))


def placement_of(world):
    return start_of(world) if world.second is None else two_agents.start_of(world)


def page_of(tmp_path, text):
    page = tmp_path / "page.md"
    page.write_text(text)
    return page


def test_a_block_that_fails_is_named_by_page_and_line(tmp_path):
    page = page_of(tmp_path, "# A page\n\n```python\nx = 1\n```\n\n```python\nx / 0\n```\n")
    with pytest.raises(ValueError, match=r'(?s)page.md", line 8.*ZeroDivisionError'):
        blocks.run(page, tmp_path)


def test_a_warning_in_a_block_is_a_failure(tmp_path):
    page = page_of(tmp_path, '```python\nimport warnings\nwarnings.warn("old")\n```\n')
    with pytest.raises(ValueError, match="UserWarning: old"):
        blocks.run(page, tmp_path)


def test_what_a_block_prints_must_be_what_the_page_says(tmp_path):
    said = "```python\nprint(1 + 1)\n```\n\n```text\n{}\n```\n"
    blocks.run(page_of(tmp_path, said.format(2)), tmp_path)
    with pytest.raises(ValueError, match="line 6: what is printed is\n2"):
        blocks.run(page_of(tmp_path, said.format(3)), tmp_path)


def test_a_command_that_fails_is_a_failure(tmp_path):
    page = page_of(tmp_path, "```sh\nhabilis worlds nowhere\n```\n")
    with pytest.raises(ValueError, match="nowhere: no such world"):
        blocks.run(page, tmp_path)


def test_a_block_with_a_title_is_a_file(tmp_path):
    page = page_of(
        tmp_path, '```text title="map.txt"\nA.CG\n```\n\n```sh\nhabilis solve map.txt\n```\n'
    )
    blocks.run(page, tmp_path)
    assert (tmp_path / "map.txt").read_text() == "A.CG\n"


def test_links_of_the_readme_lead_somewhere():
    links = re.findall(r"\]\(([^)#:]+)\)", (ROOT / "README.md").read_text("utf-8"))
    assert links
    for link in links:
        assert (ROOT / link).exists(), link


def mkdocs(*arguments, before=""):
    code = f"import sys\n{before}\nfrom mkdocs.__main__ import cli\ncli(sys.argv[1:])"
    return subprocess.run(
        [sys.executable, "-c", code, *map(str, arguments)],
        cwd=ROOT,
        env=os.environ | {"NO_MKDOCS_2_WARNING": "1"},
        capture_output=True,
        text=True,
    )


@pytest.fixture(scope="module")
def site(tmp_path_factory):
    folder = tmp_path_factory.mktemp("site")
    built = mkdocs("build", "--strict", "--site-dir", folder)
    assert built.returncode == 0, built.stderr
    return folder


# What a browser fetches by itself; where a link leads is fetched when a reader follows it.
LOADED = re.compile(
    r"""<(?:script|img|iframe|source|video|audio|embed|object)\b[^>]*?\s(?:src|srcset|data)=["']?"""
    r"""([^"'\s>]+)|<link\b(?=[^>]*rel=["']?(?:stylesheet|icon|preload|preconnect|dns-prefetch|modulepreload))"""
    r"""[^>]*?href=["']?([^"'\s>]+)""",
    re.IGNORECASE,
)
STYLED = re.compile(r"""url\(\s*["']?([^"')]+)|@import\s+["']([^"']+)""")
POLICY = "default-src 'self' file: data: blob: 'unsafe-inline'"


def elsewhere(address):
    return re.match(r"(?i)(https?:|ftp:)?//", address) is not None


def test_pages_load_nothing_from_other_hosts(site):
    pages = [*site.rglob("*.html")]
    assert len(pages) > 15
    for page in pages:
        text = page.read_text("utf-8")
        loaded = [a or b for a, b in LOADED.findall(text)] + [
            a or b for a, b in STYLED.findall(text)
        ]
        assert not [address for address in loaded if elsewhere(address)], page
    for sheet in site.rglob("*.css"):
        styled = [a or b for a, b in STYLED.findall(sheet.read_text("utf-8"))]
        assert not [address for address in styled if elsewhere(address)], sheet


def test_scripts_of_the_theme_cannot_ask_other_hosts_either(site):
    for page in site.rglob("*.html"):
        if any(page.is_relative_to(site / ours) for ours in ("multiverse", "studies")):
            assert "<script" not in page.read_text("utf-8")
            continue
        head = page.read_text("utf-8").partition("</head>")[0]
        assert f'<meta http-equiv="Content-Security-Policy" content="{POLICY}">' in head, page
        # A policy holds for what comes after it: no script stands before.
        assert "<script" not in head.partition("Content-Security-Policy")[0], page


def pictures(text):
    """The alternative text of each picture, `None` where it has none."""
    tags = re.findall(r"<img\b[^>]*>", text)
    found = [re.search(r"""\balt=(?:"([^"]*)"|'([^']*)'|([^\s>]+))""", tag) for tag in tags]
    return [one and (one[1] or one[2] or one[3] or "") for one in found]


def test_every_picture_of_the_pages_has_an_alternative_text(site):
    shown = {page: pictures(page.read_text("utf-8")) for page in site.rglob("*.html")}
    assert sum(map(len, shown.values())) > 30
    assert not [str(page) for page, texts in shown.items() if not all(texts)]


def test_every_picture_of_the_readme_has_an_alternative_text():
    readme = (ROOT / "README.md").read_text("utf-8")
    texts = re.findall(r"!\[([^\]]*)\]\(", readme)
    assert len(texts) == readme.count("![") > 2
    assert all(len(text) > 20 for text in texts)


@pytest.mark.skipif(not CHROMIUM.exists(), reason="no chromium")
def test_search_works_on_pages_that_were_opened_from_a_disk(site):
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=CHROMIUM, args=OPTIONS)
        page = browser.new_page()
        page.goto((site / "index.html").as_uri())
        page.locator("[data-md-component=search-query]").fill("persistence")
        results = page.locator(".md-search-result__link")
        results.first.wait_for()
        assert any("pairs.html" in str(one.get_attribute("href")) for one in results.all())
        browser.close()


def test_formulae_are_mathml_and_none_is_left_over(site):
    page = (site / "explanation" / "empowerment.html").read_text("utf-8")
    assert '<math xmlns="http://www.w3.org/1998/Math/MathML" display="block">' in page
    for page in site.rglob("*.html"):
        assert "arithmatex" not in page.read_text("utf-8"), page


def test_every_public_name_has_its_place_in_the_built_reference(site):
    inventory = "".join(p.read_text("utf-8") for p in (site / "reference").glob("*.html"))
    names = reference.public_names()
    for path, thing in names.items():  # at one of its public paths
        paths = [other for other, same in names.items() if same is thing]
        found = [re.search(rf'id="{re.escape(p)}(\.\w+)?"', inventory) for p in paths]
        assert any(found), path


def test_the_build_fails_on_a_public_name_that_is_not_in_the_reference(tmp_path):
    before = "import habilis\nhabilis.forgotten = lambda: 0\nhabilis.__all__.append('forgotten')"
    built = mkdocs("build", "--site-dir", tmp_path / "site", before=before)
    assert built.returncode != 0
    assert "habilis.forgotten is on no page of the reference" in built.stderr
    assert "habilis.forgotten has no docstring" in built.stderr
    assert not (tmp_path / "site").exists()


def test_the_build_fails_on_a_link_to_nowhere(tmp_path):
    docs = tmp_path / "docs"
    docs.mkdir()
    (docs / "index.md").write_text("# One\n\n[two](#two)\n")
    config = re.sub(
        r"(?s)\nnav:.*\nplugins:.*?\n(?=markdown)", "\n", (ROOT / "mkdocs.yml").read_text()
    )
    config = config.replace("docs/theme", str(ROOT / "docs" / "theme"))
    assert "anchors: warn" in config
    (tmp_path / "mkdocs.yml").write_text(config)
    (tmp_path / "docs" / "theme").mkdir()
    built = mkdocs("build", "--strict", "--config-file", tmp_path / "mkdocs.yml")
    assert built.returncode != 0
    assert "#two" in built.stderr


def complaints(thing):
    return [fault.removeprefix("a.thing") for fault in reference.faults({"a.thing": thing}, [])][1:]


def test_a_docstring_describes_arguments_results_and_errors():
    def silent(x: int) -> int:
        if x < 0:
            raise ValueError("negative")
        return x

    assert complaints(silent) == [" has no docstring"]
    silent.__doc__ = """Does something."""
    assert complaints(silent) == [
        ": its argument x is not described",
        " does not say what it returns",
        " does not say when it raises ValueError",
    ]
    silent.__doc__ = """Gives it back.

    Args:
        x, y: a number.

    Returns:
        x

    Raises:
        ValueError: it is negative.
    """
    assert complaints(silent) == [" describes an argument y that it does not have"]


def test_a_class_describes_its_attributes_and_methods():
    from dataclasses import dataclass

    @dataclass
    class Pair:
        """Two.

        Attributes:
            one: the one.
        """

        one: int
        other: int

        def swapped(self) -> "Pair":
            return Pair(self.other, self.one)

    assert complaints(Pair) == [
        ": its attribute other is not described",
        ".swapped has no docstring",
    ]


def test_lazy_names_and_those_of_the_environments_are_public_too():
    names = reference.public_names()
    assert {"habilis.train", "habilis.tabulate", "habilis.envs.WorldEnv"} <= names.keys()
    assert {f"habilis.{name}" for name in habilis.__all__} <= names.keys()


def test_a_refused_environment_has_its_reason_and_not_the_whole_error_in_the_table():
    outcomes = {line.split("|")[-2].strip() for line in environments.table().splitlines()[2:]}
    assert {one for one in outcomes if one.startswith("refused")} == {
        "refused: random",
        "refused: more than 20,000 states",
        "refused: it cannot be reset (a picture of its patterns is not in the package)",
    }
