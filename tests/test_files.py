"""Files are written whole or not at all, and what cannot be written is refused before any work."""

import os
import resource
import stat
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pytest
from disks import content, mounted

import habilis as hb
from habilis import files
from habilis.analysis.data_frames import TABLES, save_table, to_dataframe
from habilis.analysis.landscape_values import Landscape
from habilis.analysis.pairs import Pairs
from habilis.cli import VERBS as VERB_MODULES
from habilis.cli import main, parser
from habilis.files import check_file, check_folder, save_whole, write_whole
from habilis.worlds.pictures.figures import PICTURES, save_picture
from habilis.worlds.pictures.video import _SAVERS, save_video

WORLD = hb.World.parse("AP.CG\n.....\n")
MDP = hb.tabulate(WORLD)
NOISE = np.random.default_rng(0).random(200_000)  # which no format makes small


def big_table(path: Path) -> None:
    table = to_dataframe(hb.TabularMDP.deterministic(np.zeros((len(NOISE), 1), int)), NOISE)
    save_table(table, path)


def big_video(path: Path) -> None:
    pictures = np.random.default_rng(0).integers(256, size=(9, 64, 64, 3), dtype=np.uint8)
    save_video(pictures, path)


def big_landscape(path: Path) -> None:
    Landscape(NOISE.reshape(400, 500), WORLD).save(path)


def big_pairs(path: Path) -> None:
    flat = np.zeros((1, 1))
    averages = NOISE.reshape(-1, 1, 1)
    Pairs(("none",), ("can",), averages, flat.astype(int), flat, flat, flat, flat).save(path)


WRITERS = [
    *((big_table, suffix) for suffix in TABLES),
    *((big_video, suffix) for suffix in _SAVERS),
    *((lambda path: save_picture(WORLD, path, 400), suffix) for suffix in PICTURES),
    *((big_landscape, suffix) for suffix in (".npy", ".csv")),
    *((big_pairs, suffix) for suffix in (".npy", ".csv", ".parquet")),
]


def test_the_suffixes_are_those_that_the_writers_know():
    assert tuple(TABLES) == files.TABLES
    assert tuple(PICTURES) == files.PICTURES
    assert tuple(_SAVERS) == files.VIDEOS


@pytest.mark.parametrize("earlier", [None, b"what was there"])
def test_on_a_full_disk_every_writer_leaves_what_was_there(tmp_path, earlier):
    disk = tmp_path / "disk"
    with mounted(disk, "size=12k"):
        for write, suffix in WRITERS:
            path = disk / f"out{suffix}"
            if earlier is not None:
                path.write_bytes(earlier)
            before = content(disk)
            with pytest.raises((OSError, ValueError), match="No space left"):
                write(path)
            assert content(disk) == before, suffix
            path.unlink(missing_ok=True)


@contextmanager
def no_file_above(size: int) -> Iterator[None]:
    """As a full disk, for those too who may not mount one: `ulimit -f`."""
    _, most = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (size, most))
    try:
        yield
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, (most, most))


@pytest.mark.parametrize("size", [0, 100, 4096])
def test_no_writer_hides_a_full_disk_behind_an_error_of_its_library(tmp_path, size):
    yard = hb.load_world("yard")
    values = NOISE[: yard.height * yard.width].reshape(yard.height, yard.width)
    pictures = [(Landscape(values, yard).save, suffix) for suffix in PICTURES]
    writers = [pair for pair in WRITERS if pair[1] != ".mp4"]  # ffmpeg writes that one itself
    for write, suffix in [*writers, *pictures]:
        with no_file_above(size), pytest.raises((OSError, ValueError)) as refused:
            write(tmp_path / f"out{suffix}")
        assert content(tmp_path) == {}
        assert type(refused.value) in (OSError, ValueError), suffix
        if not isinstance(refused.value, OSError):
            says = (
                f"{tmp_path}/out{suffix}: cannot be written (File too large); make room there, or "
            )
            says += "name another place"
            assert str(refused.value) == says
        else:
            assert refused.value.strerror == "File too large", suffix


def test_the_command_line_on_a_full_disk_is_one_line_and_leaves_what_was_there(tmp_path, capsys):
    disk = tmp_path / "disk"
    with mounted(disk, "size=8k"):
        for verb, name in (("empowerment", "bits.csv"), ("landscape", "map.png")):
            (disk / name).write_text("earlier")
            command = [verb, "yard", "--horizon", "1", "--sensor", "object"]
            assert main([*command, "--out", str(disk / name)]) == 2
            out, err = capsys.readouterr()
            assert (out, err.count("\n")) == ("", 1)
            assert f"{disk / name}: cannot be written (No space left on device" in err
            assert content(disk) == {name: b"earlier"}
            (disk / name).unlink()


class StopError(Exception):
    pass


def test_a_writer_that_fails_leaves_what_was_there(tmp_path):
    path = tmp_path / "file"
    path.write_bytes(b"earlier")

    def fail(file):
        file.write(b"half")
        raise StopError

    for place in (path, tmp_path / "new"):
        with pytest.raises(StopError):
            write_whole(place, fail)
    assert content(tmp_path) == {"file": b"earlier"}


def test_the_file_is_there_only_when_it_is_whole(tmp_path):
    seen = []

    def write(file):
        file.write(b"first")
        file.flush()
        seen.append((tmp_path / "file").exists())

    write_whole(tmp_path / "file", write)
    assert seen == [False]
    assert content(tmp_path) == {"file": b"first"}


def test_permissions_are_kept_and_new_files_have_the_usual_ones(tmp_path):
    mask = os.umask(0o027)
    try:
        write_whole(tmp_path / "new", lambda file: file.write(b"x"))
    finally:
        os.umask(mask)
    assert stat.S_IMODE((tmp_path / "new").stat().st_mode) == 0o640
    (tmp_path / "new").chmod(0o604)
    write_whole(tmp_path / "new", lambda file: file.write(b"y"))
    assert stat.S_IMODE((tmp_path / "new").stat().st_mode) == 0o604


def test_a_link_stays_a_link(tmp_path):
    (tmp_path / "folder").mkdir()
    (tmp_path / "link").symlink_to(Path("folder") / "file")
    for text in (b"first", b"second"):
        write_whole(tmp_path / "link", lambda file, text=text: file.write(text))
        assert (tmp_path / "link").is_symlink()
        assert content(tmp_path / "folder") == {"file": text}


def test_a_pipe_gets_all_or_nothing(tmp_path):
    pipe = tmp_path / "pipe.csv"
    os.mkfifo(pipe)
    read = []
    reader = threading.Thread(target=lambda: read.append(pipe.read_bytes()))
    reader.start()
    check_file(pipe, [".csv"])
    save_table(to_dataframe(MDP), pipe)
    reader.join()
    assert read == [to_dataframe(MDP).write_csv().encode()]
    assert list(tmp_path.iterdir()) == [pipe]


def test_many_may_write_one_file_at_once(tmp_path):
    contents = [bytes([65 + n]) * 100_000 for n in range(8)]
    threads = [
        threading.Thread(target=write_whole, args=(tmp_path / "file", lambda f, c=c: f.write(c)))
        for c in contents
    ]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    assert content(tmp_path)["file"] in contents
    assert len(list(tmp_path.iterdir())) == 1


def test_names_as_long_as_the_system_allows_can_be_written(tmp_path):
    path = tmp_path / f"{'n' * 251}.csv"
    check_file(path, [".csv"])
    save_table(to_dataframe(MDP), path)
    assert [path] == list(tmp_path.iterdir())


def test_a_read_only_file_is_not_replaced(tmp_path, monkeypatch):
    path = tmp_path / "bits.csv"
    path.write_text("earlier")
    monkeypatch.setattr(os, "access", lambda place, mode: Path(place) != path)  # not even for root
    for act in (lambda: check_file(path, [".csv"]), lambda: save_whole(path, print)):
        with pytest.raises(ValueError, match="read-only"):
            act()
    assert content(tmp_path) == {"bits.csv": b"earlier"}


VERBS = {  # every verb that writes, and what it needs besides
    "worlds": ["worlds", "yard", "--out"],
    "empowerment": ["empowerment", "yard", "--horizon", "9", "--out"],
    "landscape": ["landscape", "yard", "--horizon", "9", "--out"],
    "futures": ["futures", "yard", "--horizon", "9", "--sensor", "object", "--out"],
    "estimators": ["estimators", "--quick", "--out"],
    "compare": ["compare", "yard", "--pairs", "--horizon", "9", "--out"],
    "empowerment work": ["empowerment", "yard", "--horizon", "9", "--work"],
    "landscape work": ["landscape", "yard", "--horizon", "9", "--work"],
    "estimators work": ["estimators", "--quick", "--work"],
    "compare work": ["compare", "yard", "--horizon", "9", "--work"],
    "watch gif": ["watch", "run", "--gif"],
    "watch mp4": ["watch", "run", "--mp4"],
    "plot": ["plot", "run", "--out"],
    "train": ["train", "yard", "--out"],
    "sweep": ["sweep", "SPEC.toml", "--out"],
    "reproduce": ["reproduce", "--out"],
    "study": ["study", "--out"],
    "reconstruct": ["reconstruct", "yard", "--out"],
    "studio": ["studio", "--no-browser", "--out"],
}
SUFFIXES = {"empowerment": ".csv", "watch gif": ".gif", "watch mp4": ".mp4"}
WRITES_FOLDERS = ("train", "sweep", "reproduce", "study", "reconstruct", "studio")
WRITES_FOLDERS += tuple(verb for verb in VERBS if verb.endswith(" work"))
WRITES_FILES = [verb for verb in VERBS if verb not in WRITES_FOLDERS]


def refused(verb: str, out: Path, capsys: pytest.CaptureFixture, monkeypatch) -> str:
    """A verb's error about a path before it does anything else."""
    name = VERBS[verb][0]

    def never(args):
        raise AssertionError(f"{name} was begun")

    monkeypatch.setattr(VERB_MODULES[name], "run", never)
    assert main([*VERBS[verb], str(out)]) == 2
    output, err = capsys.readouterr()
    assert output == ""
    assert err.count("\n") == 1
    return err


def test_every_verb_that_writes_is_tried_here():
    helps = {"worlds": [], "bench": [], "completion": ["bash"], "solve": ["yard"]}
    for verb in VERB_MODULES:
        words = next((words for name, words in VERBS.items() if name.split()[0] == verb), None)
        known = [verb, *helps.get(verb, [])] if words is None else [*words, "x"]
        args = vars(parser().parse_args(known))
        written = {name for name in ("out", "gif", "mp4", "work") if name in args}
        assert written == set(args.get("writes", {})), verb
        assert bool(written) == (words is not None), verb


@pytest.mark.parametrize("verb", WRITES_FILES)
def test_a_file_that_cannot_be_written_is_refused_first(verb, tmp_path, capsys, monkeypatch):
    suffix = SUFFIXES.get(verb, ".png")
    (tmp_path / f"folder{suffix}").mkdir()
    (tmp_path / "file").write_text("earlier")
    before = content(tmp_path)
    cases = {
        tmp_path / "no" / f"out{suffix}": f"(there is no folder {tmp_path / 'no'}); make it first",
        tmp_path / f"folder{suffix}": "(it is a folder); name a file in it",
        tmp_path / "file" / f"out{suffix}": f"({tmp_path / 'file'} is not a folder); name another",
        tmp_path / "out.bmp": "unknown suffix '.bmp'; let the name end with",
        tmp_path / f"{'n' * 300}{suffix}": "File name too long",
    }
    for out, says in cases.items():
        assert says in refused(verb, out, capsys, monkeypatch)
    assert content(tmp_path) == before
    if Path("/proc").is_dir():
        assert "cannot be written" in refused(verb, Path(f"/proc/out{suffix}"), capsys, monkeypatch)
    with mounted(tmp_path / "disk", "ro"):
        says = refused(verb, tmp_path / "disk" / f"out{suffix}", capsys, monkeypatch)
        assert "Read-only file system" in says


@pytest.mark.parametrize("verb", WRITES_FOLDERS)
def test_a_folder_that_cannot_be_made_is_refused_first(verb, tmp_path, capsys, monkeypatch):
    (tmp_path / "file").write_text("earlier")
    before = content(tmp_path)
    cases = {
        tmp_path / "file": f"{tmp_path / 'file'} is not a folder; name another place",
        tmp_path / "file" / "out": f"{tmp_path / 'file'} is not a folder; name another place",
        tmp_path / ("n" * 300): "the name is too long",
    }
    for out, says in cases.items():
        assert says in refused(verb, out, capsys, monkeypatch)
    assert content(tmp_path) == before
    if Path("/proc").is_dir():
        assert "cannot be written to" in refused(verb, Path("/proc/out"), capsys, monkeypatch)
    with mounted(tmp_path / "disk", "ro"):
        assert "Read-only file system" in refused(
            verb, tmp_path / "disk" / "out", capsys, monkeypatch
        )


def test_the_picture_that_plot_draws_by_default_is_checked_first_too(tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "curves.png").mkdir()
    assert main(["plot", "run"]) == 2
    assert "curves.png: cannot be written (it is a folder)" in capsys.readouterr().err


def test_a_video_without_its_extra_is_refused_first(tmp_path, capsys, monkeypatch):
    monkeypatch.setitem(sys.modules, "imageio_ffmpeg", None)
    assert main(["watch", "no-such-run", "--mp4", str(tmp_path / "video.mp4")]) == 2
    assert "pip install 'habilis[video]'" in capsys.readouterr().err


def test_checks_leave_nothing_behind(tmp_path):
    (tmp_path / "there.csv").write_text("earlier")
    for name in ("there.csv", "new.csv"):
        check_file(tmp_path / name, [".csv"])
    for folder in (tmp_path, tmp_path / "new", tmp_path / "new" / "er"):
        check_folder(folder)
    assert content(tmp_path) == {"there.csv": b"earlier"}


@pytest.mark.parametrize("name", ["a\0b.csv", "a\0b"])
def test_what_is_no_path_is_refused(name):
    check = check_folder if name.endswith("b") else lambda path: check_file(path, [".csv"])
    with pytest.raises(ValueError, match=r"is not a valid path .*null"):
        check(name)


def test_errors_name_the_file_and_the_reason(tmp_path):
    with pytest.raises(ValueError, match=r"x: cannot be written \(No such file or directory\)"):
        save_whole(tmp_path / "no" / "x", lambda file: file.write(b""))


def test_a_noisy_world_has_its_npy_too(tmp_path, capsys):
    (tmp_path / "map.txt").write_text(WORLD.text())
    out = tmp_path / "bits.npy"
    command = ["empowerment", str(tmp_path / "map.txt"), "--horizon", "1", "--slip", "0.2"]
    assert main([*command, "--out", str(out)]) == 0
    bits = hb.empowerment(hb.tabulate(WORLD, 0.2), 1)
    assert np.allclose(np.load(out), bits, atol=1e-6)
