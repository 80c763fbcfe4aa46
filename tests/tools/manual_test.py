# SPDX-License-Identifier: MIT
"""Manual pages and completions say what --help says, and man and the shells take them."""
import os
import re
import shutil
import subprocess
import tempfile
from pathlib import Path

from ecosystem import PROGRAM, shape


def options_of(text):
    """The options that a page of --help lists: lines that begin with two blanks and a dash."""
    found = set()
    for line in text.splitlines():
        match = re.match(r"  (-[-\w,]+)", line)
        if match:
            found |= set(match[1].split(","))
    return found


def check_pages(folder, helps):
    pages = folder / "man/man1"
    assert {page.name for page in pages.iterdir()} == {"shape.1"} | {f"shape-{name}.1" for name in helps}
    overview = (pages / "shape.1").read_text()
    for name, text in helps.items():
        page = (pages / f"shape-{name}.1").read_text()
        plain = re.sub(r"\\f[BIR]", "", page).replace("\\-", "-").replace("\\&", "")
        for option in options_of(text):
            assert re.search(rf"{re.escape(option)}\b", plain), f"shape-{name}(1) lacks {option}"
        described = set(re.findall(r"(?<![\w-])--[a-z][-a-z]+", plain))
        assert described <= set(re.findall(r"--[a-z][-a-z]+", text)), f"shape-{name}(1) knows more than --help"
        # Every word of the help, in its order of sections: nothing is left out.
        words = set(re.findall(r"[A-Za-z]{4,}", plain.lower().replace("\\e", "")))
        missing = {word for word in re.findall(r"[A-Za-z]{4,}", text.lower())} - words - {
            "usage", "positionals", "options", "text", "number", "integer", "print", "this"}
        assert not missing, f"shape-{name}(1) lacks the words {missing}"
        assert "REQUIRED" not in page, f"shape-{name}(1) says twice what is required"
        codes = re.findall(r"^\.TP\n\\fB(\d+)\\fR$", page[page.index('.SH "EXIT STATUS"'):], re.MULTILINE)
        assert codes == ["0", "1", "2", "3", "4", "5", "6", "130"], (name, codes)
        assert f"shape\\-{name}" in overview, f"shape(1) lacks {name}"
    if shutil.which("man"):
        for page in sorted(pages.iterdir()):
            done = subprocess.run(["man", "--warnings", "-l", str(page)], stdout=subprocess.PIPE,
                                  stderr=subprocess.PIPE, text=True,
                                  env={**os.environ, "LC_ALL": "C.UTF-8", "MANROFFSEQ": "", "MANWIDTH": "80"})
            assert done.returncode == 0 and done.stderr == "", (page.name, done.stderr)
            assert "NAME" in done.stdout and "SYNOPSIS" in done.stdout
        print(f"man takes {len(list(pages.iterdir()))} pages without a warning")
    else:
        print("man is not there; its pages were read, not shown")


def completed_by_bash(script, words):
    line = (f"source '{script}'; COMP_WORDS=({' '.join(map(repr, words))}); COMP_CWORD={len(words) - 1}; "
            f"_shape shape {words[-1]!r} {words[-2]!r}; printf '%s\\n' \"${{COMPREPLY[@]}}\"")
    done = subprocess.run(["bash", "--norc", "-c", line], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
    assert done.returncode == 0 and done.stderr == "", done.stderr
    return set(done.stdout.split())


def check_bash(folder, helps):
    script = folder / "bash-completion/completions/shape"
    assert set(helps) | {"help"} <= completed_by_bash(script, ["shape", ""])
    assert completed_by_bash(script, ["shape", "gen"]) == {"generate"}
    assert completed_by_bash(script, ["shape", "help", "gen"]) == {"generate"}
    for name, text in helps.items():
        offered = completed_by_bash(script, ["shape", name, "-"])
        assert offered == options_of(text), (name, offered ^ options_of(text))
    assert completed_by_bash(script, ["shape", "stats", "x.h5", "--space", ""]) == {"edge", "procrustes"}
    assert completed_by_bash(script, ["shape", "stats", "--space", "=", "p"]) == {"procrustes"}
    assert completed_by_bash(script, ["shape", "stats", "--labels", ""]) == set()  # bash offers files then
    if shutil.which("shellcheck"):
        subprocess.run(["shellcheck", "--shell=bash", str(script)], check=True)
    print("bash completes every command and option")


def check_zsh(folder, helps):
    script = folder / "zsh/site-functions/_shape"
    text = script.read_text()
    for name, page in helps.items():
        part = re.search(rf"^            {name}\)\n(.*?);;", text, re.DOTALL | re.MULTILINE)[1]
        assert set(re.findall(r"^ +'\*?(-[-\w]+)\[", part, re.MULTILINE)) == options_of(page), name
    if shutil.which("zsh") is None:
        return print("zsh is not there; its completion was read, not run")
    # As a person would press the tab key: in a terminal of its own.
    lines = f"""
zmodload zsh/zpty
zpty z zsh -f -i
zpty -w z 'PS1=; fpath=({folder}/zsh/site-functions $fpath); autoload -U compinit; compinit -u -D; zstyle ":completion:*" list-prompt ""; LISTMAX=0; echo READY$((1+1))'
zpty -r z output '*READY2*'
zpty -w -n z $'shape stats --spac\\t pro\\t\\C-a"\\C-e"\\C-a echo \\n'
zpty -r z output '*procrustes*' && print -r -- FOUND
zpty -d z
"""
    done = subprocess.run(["zsh", "-f", "-c", lines], stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True,
                          timeout=60, cwd=folder)
    assert "FOUND" in done.stdout, done.stdout
    print("zsh completes")


def check_fish(folder, helps):
    script = folder / "fish/vendor_completions.d/shape.fish"
    text = script.read_text()
    for name, page in helps.items():
        lines = [line for line in text.splitlines() if f"seen_subcommand_from {name}'" in line]
        offered = {f"--{word}" for line in lines for word in re.findall(r" -l ([-\w]+)", line)}
        offered |= {f"-{word}" for line in lines for word in re.findall(r" -s (\w)", line)}
        assert offered == options_of(page), (name, offered ^ options_of(page))
    if shutil.which("fish") is None:
        return print("fish is not there; its completion was read, not run")

    def completed(line):
        done = subprocess.run(["fish", "--no-config", "-c", f"source {script}; complete -C '{line}'"],
                              stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, cwd=folder,
                              env={**os.environ, "HOME": str(folder)})
        assert done.returncode == 0 and done.stderr == "", done.stderr
        return {word.split("\t")[0] for word in done.stdout.splitlines()}

    assert set(helps) | {"help"} <= completed("shape ")
    assert completed("shape stats --space ") == {"edge", "procrustes"}
    assert {"--labels", "--modes"} <= completed("shape stats --")
    print("fish completes")


with tempfile.TemporaryDirectory() as name:
    place = Path(name)
    listed = re.search(r"Subcommands:\n(.*?)\n\n", shape(place, "--help"), re.DOTALL)[1]
    commands = [line.split()[0] for line in listed.splitlines()]
    assert len(commands) > 20
    pages = {command: shape(place, command, "--help") for command in commands}
    shape(place, "help", "--write", "share")
    shape(place, "help", "--write", "again")
    check_pages(place / "share", pages)
    check_bash(place / "share", pages)
    check_zsh(place / "share", pages)
    check_fish(place / "share", pages)
    for file in (place / "share").rglob("*"):
        if file.is_file():
            twin = place / "again" / file.relative_to(place / "share")
            assert twin.read_bytes() == file.read_bytes()
    # What cannot be written is said.
    (place / "file").write_text("")
    for words, code in ((["help", "--write"], 2), (["help", "--write", "a", "b"], 2), (["help", "--write", "file/x"], 5)):
        done = subprocess.run([PROGRAM, *words], cwd=place, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True)
        assert done.returncode == code and "shape: error: " in done.stderr, (words, done)
