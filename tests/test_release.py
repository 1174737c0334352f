"""Releases: packages that install and run from anywhere, and their metadata."""

import json
import math
import os
import re
import shutil
import subprocess
import sys
import tarfile
import tomllib
import urllib.request
import zipfile
from email import message_from_bytes
from pathlib import Path

import pytest
import yaml
from packaging.utils import canonicalize_name

import habilis
import hatch_build
from studio import page, scene, studio

ROOT = Path(__file__).parents[1]
PAGE = ROOT / "src" / "habilis" / "studio" / "page"
PAGE_FILES = ["index.html", "assets/studio.css", "assets/studio.js"]
HEADINGS = ["New", "Breaking changes", "Fixed", "Performance"]


def apart():
    """Our environment, without our sources on its path."""
    return {k: v for k, v in os.environ.items() if k not in ("PYTHONPATH", "VIRTUAL_ENV")}


def ran(*command, where, **environment):
    """The output of a command, in a folder, without our sources on its path."""
    done = subprocess.run(
        [str(word) for word in command],
        cwd=where,
        env=apart() | environment,
        capture_output=True,
        text=True,
    )
    assert done.returncode == 0, f"{command}\n{done.stdout}\n{done.stderr}"
    return done.stdout


def sources():
    """The files of a fresh clone, or of an unpacked sdist, as paths from its root."""
    if (ROOT / ".git").exists():
        return [Path(name) for name in ran("git", "ls-files", where=ROOT).splitlines()]
    made = {".venv", "__pycache__", "site", "dist", ".pytest_cache", "PKG-INFO"}
    files = (path.relative_to(ROOT) for path in ROOT.rglob("*") if path.is_file())
    return [path for path in files if made.isdisjoint(path.parts)]


@pytest.fixture(scope="module")
def built(tmp_path_factory):
    """The folder of both packages, built of a clean copy."""
    copy, out = tmp_path_factory.mktemp("copy"), tmp_path_factory.mktemp("dist")
    for path in sources():
        if (ROOT / path).exists():  # else it is about to be removed
            (copy / path).parent.mkdir(parents=True, exist_ok=True)
            shutil.copyfile(ROOT / path, copy / path)
    ran(sys.executable, "-m", "build", "--outdir", out, where=copy)
    return out


@pytest.fixture(scope="module")
def wheel(built):
    (path,) = built.glob("*.whl")
    return path


@pytest.fixture(scope="module")
def sdist(built):
    (path,) = built.glob("*.tar.gz")
    return path


@pytest.fixture(scope="module")
def unpacked(sdist, tmp_path_factory):
    folder = tmp_path_factory.mktemp("sdist")
    with tarfile.open(sdist) as archive:
        archive.extractall(folder, filter="data")
    (inside,) = folder.iterdir()
    return inside


def test_the_wheel_has_what_the_package_needs_and_nothing_else(wheel):
    names = set(zipfile.ZipFile(wheel).namelist())
    ours = {str(path.relative_to("src")) for path in sources() if path.parts[0] == "src"}
    assert {"habilis/py.typed", "habilis/worlds/builtin/yard.txt"} <= ours
    assert {f"habilis/studio/page/{name}" for name in PAGE_FILES} <= ours
    assert any(name.startswith("habilis/studies/data/maps/") for name in ours)
    assert any(name.endswith((".html", ".jinja")) for name in ours)
    info = f"habilis-{habilis.__version__}.dist-info"
    assert {name for name in names if not name.startswith(f"{info}/")} == ours
    assert f"{info}/licenses/LICENSE" in names


def test_the_sdist_has_all_of_the_repository_that_is_not_about_the_repository(unpacked):
    there = {path.relative_to(unpacked) for path in unpacked.rglob("*") if path.is_file()}
    missing = {path for path in sources() if path.parts[0] != ".ci"} - there
    assert missing <= {Path(".gitignore")}
    assert there - set(sources()) == {Path("PKG-INFO")}


def test_the_tests_of_the_sdist_run(unpacked):
    environment = {"PYTHONPATH": str(unpacked / "src")}
    tests = ["tests/test_mdp.py", "tests/test_package.py", "tests/worlds/test_rules.py"]
    command = [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider"]
    assert " passed" in ran(*command, *tests, where=unpacked, **environment)
    ran(*command, "--collect-only", "tests", where=unpacked, **environment)


def install(python, package):
    pip = [python, "-m", "pip", "--disable-pip-version-check"]
    constraints = ["--constraint", ROOT / "constraints.txt"]
    ran(*pip, "install", "--quiet", *constraints, package, where=python.parent)
    ran(*pip, "check", where=python.parent)


def installed(package, folder):
    """The interpreter of an environment that has a package, and what it needs, only."""
    ran(sys.executable, "-m", "venv", folder / "venv", where=folder)
    python = folder / "venv" / "bin" / "python"
    install(python, package)
    return python


@pytest.fixture(scope="module")
def wheel_installed(wheel, tmp_path_factory):
    return installed(wheel, tmp_path_factory.mktemp("wheel"))


@pytest.fixture(scope="module")
def sdist_installed(sdist, tmp_path_factory):
    return installed(sdist, tmp_path_factory.mktemp("sdist"))


@pytest.mark.parametrize("kind", ["wheel", "sdist"])
def test_it_installs_into_an_empty_environment_and_runs(kind, request, tmp_path):
    python = request.getfixturevalue(f"{kind}_installed")
    elsewhere = tmp_path
    said = ran(python.parent / "habilis", "compare", "yard", "--horizon", "3", where=elsewhere)
    averages = dict(re.findall(r"^ *(\w+)  (\d\.\d{4})", said, re.MULTILINE))
    assert averages == {"picker": "0.5241", "broom": "0.2761", "none": "0.2303"}
    code = "import habilis; print(habilis.__file__, habilis.__version__)"
    file, version = ran(python, "-c", code, where=elsewhere).split()
    assert Path(file).is_relative_to(python.parents[1])
    assert version == habilis.__version__
    assert (Path(file).parent / "py.typed").exists()


USES = {  # of each extra: a line that needs it
    "gymnasium": "import gymnasium, habilis; "
    "gymnasium.make('habilis/Yard-v0').reset(seed=0); print('used')",
    "learn": "import habilis as hb; run = hb.train(hb.Config(world='yard', runs=1, episodes=2)); "
    "print('used' if run.episodes.height == 2 else run)",
    "learn,sweep": "from habilis.sweeps import search; import ray; print('used')",
    "storm": "import habilis as hb, stormpy; hb.TabularMDP.from_storm; print('used')",
    "video": "import habilis as hb; world = hb.load_world('yard'); "
    "hb.save_video([world, world], 'a.mp4'); print('used')",
}


@pytest.mark.parametrize("extra", USES)
def test_with_an_extra_alone_the_wheel_does_what_the_extra_is_for(wheel, extra, tmp_path):
    python = installed(f"{wheel}[{extra}]", tmp_path)
    assert ran(python, "-W", "error", "-c", USES[extra], where=tmp_path).split() == ["used"]


def test_the_wheel_and_the_extra_studio_are_all_that_the_studio_needs(
    wheel, wheel_installed, tmp_path
):
    install(wheel_installed, f"{wheel}[studio]")
    command = [str(wheel_installed.parent / "habilis")]
    yard = habilis.load_world("yard")
    with studio(habilis=command, cwd=tmp_path, env=apart()) as address, page(address) as there:
        with urllib.request.urlopen(address) as answer:
            shown = answer.read().decode()
        assets = re.findall(r'(?:src|href)="\./(assets/[\w.]+)"', shown)
        assert sorted(["index.html", *assets]) == sorted(PAGE_FILES)
        for asset in assets:
            with urllib.request.urlopen(address + asset) as answer:
                assert answer.read() == (PAGE / asset).read_bytes()
        assert shown == (PAGE / "index.html").read_text("utf-8")
        bits = there.ask("measure", scene=scene(yard, sensor="object", horizon=3))["landscape"]
        assert bits[8][4] == pytest.approx(math.log2(6))
        refused = there.ask("train", scene=scene(yard), settings={})["error"]
        assert refused == "jax is not installed; run: pip install 'habilis[learn]'"


ADDRESS = "https://example.org/someone/habilis"


def described(address, version="v1.2.3"):
    """The README as an index shows it, built with an address or without."""
    return hatch_build.with_links((ROOT / "README.md").read_text("utf-8"), address, version)


def test_on_an_index_every_picture_and_link_of_the_readme_is_absolute():
    links = re.findall(r"(!?)\[[^\[\]]+\]\((\S+)\)", described(ADDRESS))
    assert len(links) > 20
    assert f"{ADDRESS}/raw/v1.2.3/docs/landscape.png" in [to for picture, to in links if picture]
    assert f"{ADDRESS}/blob/v1.2.3/docs/tutorial.md" in [to for picture, to in links if not picture]
    assert not [to for _, to in links if not to.startswith("https://")]


def test_where_no_address_is_known_the_readme_has_the_texts_of_links_alone():
    shown = described(None)
    assert "](docs" not in shown
    assert "*The studio: the yard, its landscape" in shown
    assert "a tutorial, a gallery, notebooks," in " ".join(shown.split())


@pytest.mark.parametrize(
    "remote",
    [
        "https://example.org/someone/habilis.git",
        "git@example.org:someone/habilis.git",
        "ssh://git@example.org/someone/habilis",
        "ssh://git@example.org:2222/someone/habilis",
        "https://example.org/someone/habilis/",
    ],
)
def test_the_address_of_the_repository_is_that_of_its_remote(remote, monkeypatch, tmp_path):
    monkeypatch.delenv("HABILIS_REPOSITORY", raising=False)
    ran("git", "init", "--quiet", where=tmp_path)
    assert hatch_build.repository(tmp_path) is None
    ran("git", "remote", "add", "origin", remote, where=tmp_path)
    assert hatch_build.repository(tmp_path) == ADDRESS
    monkeypatch.setenv("HABILIS_REPOSITORY", "https://example.org/other/place")
    assert hatch_build.repository(tmp_path) == "https://example.org/other/place"


def test_a_remote_keeps_its_port_and_a_machine_without_git_has_none(monkeypatch, tmp_path):
    monkeypatch.setenv("HABILIS_REPOSITORY", "https://example.org:8443/someone/habilis.git")
    assert hatch_build.repository(tmp_path) == "https://example.org:8443/someone/habilis"
    monkeypatch.setenv("HABILIS_REPOSITORY", "https://name:secret@example.org/someone/habilis")
    assert hatch_build.repository(tmp_path) is None
    monkeypatch.delenv("HABILIS_REPOSITORY")
    (tmp_path / ".git").mkdir()
    monkeypatch.setenv("PATH", str(tmp_path))
    assert hatch_build.repository(tmp_path) is None


def test_the_remote_of_a_clone_of_a_folder_is_no_address(monkeypatch, tmp_path):
    monkeypatch.delenv("HABILIS_REPOSITORY", raising=False)
    ran("git", "init", "--quiet", where=tmp_path)
    ran("git", "remote", "add", "origin", "/somewhere/habilis", where=tmp_path)
    assert hatch_build.repository(tmp_path) is None


def test_code_of_the_readme_is_on_an_index_as_it_is():
    def code(text):
        return re.findall(r"(?s)```.*?```", text)

    assert code(described(None)) == code((ROOT / "README.md").read_text("utf-8"))


def test_both_packages_have_the_same_description(wheel, sdist):
    metadata = f"habilis-{habilis.__version__}.dist-info/METADATA"
    of_wheel = message_from_bytes(zipfile.ZipFile(wheel).read(metadata))
    with tarfile.open(sdist) as archive:
        inside = archive.extractfile(f"habilis-{habilis.__version__}/PKG-INFO")
        assert inside is not None
        of_sdist = message_from_bytes(inside.read())
    assert of_wheel["Description-Content-Type"] == "text/markdown"
    assert of_wheel.get_payload() == of_sdist.get_payload()
    assert "# Habilis" in str(of_wheel.get_payload())
    assert not re.findall(r"\]\((?!https://|#)", str(of_wheel.get_payload()))


def pinned():
    lines = (ROOT / "constraints.txt").read_text("utf-8").splitlines()
    pins = (line.split("==") for line in lines if "==" in line)
    return {canonicalize_name(name): version for name, version in pins}


BILL = json.loads((ROOT / "sbom.cdx.json").read_text("utf-8"))


def test_the_bill_of_materials_names_this_version_and_what_is_pinned():
    assert BILL["metadata"]["component"]["version"] == habilis.__version__
    bill = {canonicalize_name(one["name"]): one["version"] for one in BILL["components"]}
    assert len(bill) > 40
    assert bill == {name: version for name, version in pinned().items() if name in bill}


def test_the_bill_of_materials_has_every_dependency_of_the_extras():
    project = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["project"]
    extras = project["optional-dependencies"]
    wanted = [*project["dependencies"]]
    for extra in set(extras) - {"dev", "docs"}:
        wanted += extras[extra]
    names = {canonicalize_name(re.split(r"[\[<>=~ ]", one)[0]) for one in wanted}
    (roots,) = (one for one in BILL["dependencies"] if one["ref"].startswith("habilis=="))
    assert {canonicalize_name(one.split("==")[0]) for one in roots["dependsOn"]} == names


def test_every_package_in_the_bill_of_materials_has_a_licence_and_no_address():
    assert not [one["name"] for one in BILL["components"] if not one["licenses"]]
    assert "://" not in json.dumps({k: v for k, v in BILL.items() if k != "$schema"})


def test_the_wheel_ships_the_bill_of_materials(wheel):
    name = f"habilis-{habilis.__version__}.dist-info/sboms/sbom.cdx.json"
    assert json.loads(zipfile.ZipFile(wheel).read(name)) == BILL


def test_the_version_is_one_number_everywhere():
    citation = yaml.safe_load((ROOT / "CITATION.cff").read_text("utf-8"))
    assert re.fullmatch(r"\d+\.\d+\.\d+(\.dev\d+|rc\d+)?", habilis.__version__)
    assert str(citation["version"]) == habilis.__version__
    newest = re.search(r"^## (\S+)", (ROOT / "CHANGELOG.md").read_text("utf-8"), re.MULTILINE)
    assert newest is not None
    assert newest[1] == habilis.__version__


def test_the_changelog_has_its_headings_in_their_order_and_no_others():
    versions = (ROOT / "CHANGELOG.md").read_text("utf-8").split("\n## ")
    assert versions[0].strip() == "# Changelog"
    for version in versions[1:]:
        assert re.match(r"\d+\.\d+\.\d+ \((unreleased|\d{4}-\d{2}-\d{2})\)\n", version)
        assert re.findall(r"^#+ (.*)$", version, re.MULTILINE) == HEADINGS


def test_the_citation_names_the_software_and_the_paper():
    citation = yaml.safe_load((ROOT / "CITATION.cff").read_text("utf-8"))
    assert citation["cff-version"] == "1.2.0"
    assert {"message", "title", "authors", "version", "license", "type"} <= citation.keys()
    assert citation["license"] == "MIT"
    assert (ROOT / "LICENSE").read_text("utf-8").startswith("MIT License")
    for entry in (citation, *citation["references"]):
        assert entry["title"]
        for author in entry["authors"]:
            assert author.keys() <= {"name", "family-names", "given-names"}
            assert all(author.values())
    (paper,) = citation["references"]
    assert paper["type"] == "conference-paper"
    assert paper["title"] in " ".join((ROOT / "README.md").read_text("utf-8").split())
    assert [author["family-names"] for author in paper["authors"]] == [
        "Rasheed",
        "Polani",
        "Catenacci Volpi",
    ]
    assert paper["year"] == 2023
    bibliography = (ROOT / "docs" / "bibliography.md").read_text("utf-8")
    assert f"https://doi.org/{paper['doi']})" in bibliography
