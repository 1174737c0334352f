"""`habilis studio` as a process."""

import signal
import socket
import subprocess
import sys
import urllib.request

import pytest

import habilis as hb
from habilis.cli import main
from studio import page, scene

COMMAND = [sys.executable, "-m", "habilis", "studio", "--no-browser"]


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
@pytest.mark.parametrize("busy", [False, True])
def test_it_prints_its_address_serves_and_ends_on_a_signal(number, busy):
    with subprocess.Popen(COMMAND, stdout=-1, stderr=-1, text=True) as process:
        assert process.stdout is not None
        line = process.stdout.readline()
        address = next(word for word in line.split() if word.startswith("http://127.0.0.1:"))
        with urllib.request.urlopen(address) as answer:
            assert answer.status == 200
        with page(address) as there:
            yard = hb.load_world("yard")
            assert "landscape" in there.ask("measure", scene=scene(yard))
            if busy:
                there.send("measure", scene=scene(yard, horizon=5, slip=0.3))
            process.send_signal(number)
            out, errors = process.communicate()
    assert errors == ""
    assert out == ""
    assert process.returncode == (0 if number == signal.SIGINT else -signal.SIGTERM)


def test_several_can_run_side_by_side_on_ports_that_are_free():
    with (
        subprocess.Popen(COMMAND, stdout=-1, text=True) as one,
        subprocess.Popen(COMMAND, stdout=-1, text=True) as other,
    ):
        assert one.stdout is not None
        assert other.stdout is not None
        assert one.stdout.readline() != other.stdout.readline()
        one.terminate()
        other.terminate()


def refused(capsys, *arguments):
    assert main(["studio", "--no-browser", *map(str, arguments)]) == 2
    out, errors = capsys.readouterr()
    assert out == ""
    assert len(errors.splitlines()) == 1
    return errors


def test_bad_arguments_are_one_line_and_exit_2(capsys, tmp_path):
    assert "no_run" in refused(capsys, tmp_path / "no_run")
    assert "port is 70000" in refused(capsys, "--port", 70000)
    assert "invalid int value" in refused(capsys, "--port", "x")
    assert "cannot listen there" in refused(capsys, "--host", "192.0.2.1")
    assert "cannot listen there" in refused(capsys, "--host", "no such host")
    assert "tool 'spoon' is unknown" in refused(capsys, "--tool", "spoon")
    assert "tool 'rake' is given twice or built in; leave it out" in refused(
        capsys, "--tool", "rake"
    )
    (tmp_path / "config.json").write_text("{")
    assert "is damaged" in refused(capsys, tmp_path)
    assert "config.json is not a folder" in refused(capsys, "--out", tmp_path / "config.json" / "a")


def test_a_port_that_is_taken_is_refused(capsys):
    with socket.socket() as taken:
        taken.bind(("127.0.0.1", 0))
        taken.listen()
        errors = refused(capsys, "--port", taken.getsockname()[1])
    assert "give another --host or --port" in errors
