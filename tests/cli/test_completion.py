"""Shells complete commands: asked of the shells themselves."""

import shutil
import subprocess
from pathlib import Path

import pytest

from habilis.cli import VERBS, main
from habilis.cli.completion import SHELLS

BASH = """
source "$1"; shift
COMP_WORDS=("$@"); COMP_CWORD=$(( $# - 1 ))
_shtab_habilis "$1" "${COMP_WORDS[COMP_CWORD]}" "${COMP_WORDS[COMP_CWORD-1]}"
printf '%s\\n' "${COMPREPLY[@]}"
"""
FISH = "source $argv[1]; complete -C (string join ' ' -- $argv[2..])"
ZSH = """
zmodload zsh/zpty
zpty -b shell zsh -f -i
zpty -w shell "PROMPT=''; fpath=($1:h \\$fpath); autoload -Uz compinit && compinit -u -D"
zpty -w shell "bindkey '^I' complete-word; setopt noautomenu; stty cols 200; print REA''DY"
repeat 300 { zpty -r -t shell line && [[ $line == *READY* ]] && break; sleep 0.1 }
shift
zpty -w -n shell "$*"$'\\t'
found=""
repeat 100 {
  zpty -r -t shell line && found+=$line || sleep 0.1
  [[ $found == *"$*"?* ]] && break
}
sleep 0.3
while { zpty -r -t shell line } { found+=$line }
print -r -- $found
"""
COMMANDS = {
    "bash": ["bash", "-c", BASH, "-"],
    "fish": ["fish", "-c", FISH],
    "zsh": ["zsh", "-fc", ZSH, "-"],
}
INSTALLED = [
    pytest.param(shell, marks=pytest.mark.skipif(not shutil.which(shell), reason=f"no {shell}"))
    for shell in SHELLS
]


@pytest.fixture(scope="module")
def scripts(tmp_path_factory: pytest.TempPathFactory) -> Path:
    return tmp_path_factory.mktemp("completion")


@pytest.fixture
def complete(scripts: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]):
    """What a shell makes of a command's beginning, in a folder with a file and a folder."""
    (tmp_path / "my_map.txt").write_text("A.CG\n")
    (tmp_path / "my_runs").mkdir()

    def completed(shell: str, *words: str) -> str:
        script = scripts / f"{shell}_" / "_habilis"
        if not script.exists():
            assert main(["completion", shell]) == 0
            script.parent.mkdir()
            script.write_text(capsys.readouterr().out)
        command = [*COMMANDS[shell], str(script), "habilis", *words]
        done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, check=True)
        assert done.stderr == ""
        return done.stdout

    return completed


@pytest.mark.parametrize("shell", INSTALLED)
@pytest.mark.parametrize(
    ("words", "found"),
    [
        (["so"], "solve"),
        (["solve", "corri"], "corridor"),
        (["solve", "my_m"], "my_map.txt"),
        (["landscape", "yard", "--sens"], "--sensor"),
        (["landscape", "yard", "--sensor", "o"], "object"),
        (["solve", "yard", "--tool", "b"], "broom"),
        (["solve", "yard", "--tool", "my_m"], "my_map.txt"),
        (["compare", "yard", "--tools", "st"], "stick"),
        (["train", "yard", "--algorithm", "pp"], "ppo"),
        (["watch", "my_r"], "my_runs"),
        (["completion", "fi"], "fish"),
    ],
)
def test_a_shell_completes(shell: str, words: list[str], found: str, complete):
    assert found in complete(shell, *words)


@pytest.mark.parametrize("shell", [s for s in INSTALLED if s.values[0] != "zsh"])
def test_a_shell_lists_every_verb(shell: str, complete):
    listed = {line.partition("\t")[0] for line in complete(shell, "").splitlines()}
    assert set(VERBS) <= listed


def test_another_shell_is_refused_in_a_line(capsys: pytest.CaptureFixture[str]):
    assert main(["completion", "csh"]) == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert err.count("\n") == 1
    assert "'csh'" in err
