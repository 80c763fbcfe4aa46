# SPDX-License-Identifier: MIT
"""Every key that --json prints is in docs/json.md with the type that it says, and every key there is printed; errors
are JSON too."""
import json
import math
import re
import shutil
import struct
import subprocess
import sys
import tempfile
from collections import defaultdict
from pathlib import Path

from ecosystem import PROGRAM, SOURCE

PAGE = SOURCE / "docs/json.md"
LABELS = ["--labels", "faces/labels.csv"]
SMILE = ["--from", "expression=neutral", "--to", "expression=happy"]
PAIR = ["--pair-by", "subject", *SMILE]

# Commands with the options that bring further keys; they stand on the files of those before them.
RUNS = [
    ["synth", "--list"],
    ["synth", "faces", "-o", "faces", "--count", "4", "--vertices", "300"],
    ["synth", "icosahedron", "-o", "ball"],
    ["collect", "faces", *LABELS, "-o", "faces.h5"],
    ["check", "faces", "broken.obj", "twice.obj"],
    ["check", "twice.obj", "--fix", "fixed"],
    ["check", "broken.obj", "--fix", "left"],
    ["check", "ball", "ball.obj"],
    ["stats", "faces.h5", "-o", "model.h5", "--bootstrap", "20"],
    ["stats", "faces.h5", "-o", "krylov.h5", "--modes", "3", "--memory", "16M", "--algorithm", "krylov"],
    ["stats", "faces/s000_happy.ply", "faces/s001_angry.ply", "-o", "two.h5"],
    ["stats", "faces.h5", "-o", "updated.h5", "--update", "two.h5"],
    ["stats", "faces.h5", "-o", "aligned.h5", "--space", "procrustes"],
    ["project", "model.h5", "faces", *LABELS, "-o", "scores.csv", "--plot", "scores.svg"],
    ["distance", "faces.h5", "-o", "d.csv", "--mds", "mds.csv", "--cluster", "c.csv", "--plot", "d.svg",
     "--heat-map", "h.svg"],
    ["quality", "faces.h5", "-o", "q.csv", "--modes", "1,2", "--tests", "2", "--samples", "2"],
    ["generate", "model.h5", "--mode", "1", "--sigma", "-9:9:2", "-o", "mode1"],
    ["generate", "model.h5", "--sample", "2", "-o", "samples", "--feasible", "--residuals"],
    ["generate", "model.h5", "--mode", "1", "--sigma", "-1:1:3", "--avoid-contact", "-o", "mode1.glb"],
    ["generate", "aligned.h5", "--mean", "-o", "mean.ply"],
    ["groups", "faces.h5", "--by", "expression", "--within", "subject", "-o", "g.csv", "--means", "means",
     "--bootstrap", "20", "--permutations", "19"],
    ["groups", "faces.h5", "--by", "expression", "-o", "g3.csv", "--bootstrap", "20", "--memory", "100M"],
    ["classify", "faces.h5", "--by", "expression", "-o", "c3.csv", "--modes", "1", "--memory", "100M"],
    ["regress", "faces.h5", "--on", "size", "-o", "r3.csv", "--memory", "100M"],
    ["groups", "faces.h5", "--by", "expression", "--adjust-for", "size", "-o", "g2.csv", "--bootstrap", "20"],
    ["classify", "faces.h5", "--by", "expression", "-o", "confusion.csv", "--leave-out", "subject",
     "--predictions", "p.csv"],
    ["regress", "faces.h5", "--on", "size", "-o", "r.csv", "--permutations", "19", "--expected", "expected",
     "--at", "2000", "--corrected", "corrected"],
    ["remove", "faces.h5", "--modes", "1", "-o", "removed"],
    ["difference", "faces.h5", *PAIR, "-o", "smile.h5", "--effects", "effects.ply"],
    ["difference", "faces.h5", *SMILE, "-o", "groups.h5", "--apply", "--mesh", "smiling.ply", "--effects", "groups.ply"],
    ["difference", "--load", "smile.h5", "--onto", "faces/s000_angry.ply", "--mesh", "both.ply"],
    ["interpolate", "faces/s000_happy.ply", "faces/s001_angry.ply", "--frames", "3", "-o", "frames"],
    ["interpolate", "faces/s000_happy.ply", "faces/s001_angry.ply", "--frames", "5", "-o", "far",
     "--extrapolate", "--range", "-0.1:1.1", "--keyframes", "2"],
    ["interpolate", "faces/s000_happy.ply", "faces/s001_angry.ply", "--frames", "3", "-o", "morph.glb"],
    ["interpolate", "faces/s000_happy.ply", "faces/s001_angry.ply", "faces/s002_angry.ply", "--path", "polygon",
     "--frames", "4", "-o", "around"],
    ["interpolate", *(f"still{i}.ply" for i in range(8)), "--frames", "8", "-o", "jumping"],
    ["reconstruct", "--reference", "faces/s000_happy.ply", "-o", "again.ply"],
    ["conformal", "ball.obj", "-o", "sphere.ply"],
    ["conformal", "ball.obj", "-o", "morph", "--steps", "3", "--end-gap"],
    ["draw", "mean.ply", "-o", "mean.svg"],
    ["draw", "effects.ply", "--color-by", "effect", "-o", "effects.svg"],
    ["explore", "model.h5", "-o", "page.html"],
    ["report", "model.h5", "-o", "page2.html"],
    ["export", "model.h5", "--to", "statismo", "-o", "statismo.h5"],
    ["fit", "faces/s000_neutral.ply", "faces/s001_neutral.ply", "-o", "fitted"],
    ["fit", "faces/s000_neutral.ply", "faces/s001_neutral.ply", "broken.obj", "-o", "fitted2",
     "--landmarks", "marks.csv"],
    ["fit", "model.h5", "faces/s001_neutral.ply", "-o", "fitted3"],
    ["synth", "scans", "--count", "2", "--vertices", "300", "-o", "raw"],
    ["fit", "raw/template.ply", "raw/scans", "-o", "fitted4", "--rounds", "1", "--no-search"],
    ["fit", "raw/template.ply", "raw/scans/s000_neutral.ply", "-o", "fitted5", "--landmarks", "moved.csv"],
    ["generate", "model.h5", "--sample", "2", "--shard", "1/1", "-o", "many/"],
    ["merge", "many/"],
    ["info", "faces.h5"],
    ["info", "model.h5"],
    ["info", "aligned.h5"],
    ["info", "smile.h5"],
]


def values_of(value, prefix=""):
    """Path and value of every key, with [] for each list on the way."""
    if isinstance(value, dict):
        for key, inner in value.items():
            path = f"{prefix}.{key}" if prefix else key
            yield path, inner
            yield from values_of(inner, path)
    elif isinstance(value, list):
        for inner in value:
            yield from values_of(inner, prefix + "[]")


def is_integer(value):
    return isinstance(value, int) and not isinstance(value, bool)


def is_number(value):
    return is_integer(value) or isinstance(value, float)


def list_of(holds):
    return lambda value: isinstance(value, list) and all(map(holds, value))


TYPES = {
    "integer": is_integer,
    "number": is_number,
    "text": lambda value: isinstance(value, str),
    "true or false": lambda value: isinstance(value, bool),
    "object": lambda value: isinstance(value, dict),
    "list": lambda value: isinstance(value, list),
    "list of text": list_of(lambda value: isinstance(value, str)),
    "list of integers": list_of(is_integer),
    "list of numbers": list_of(is_number),
    "list of two numbers": lambda value: list_of(is_number)(value) and len(value) == 2,
    "list of lists": list_of(lambda value: isinstance(value, list)),
}


def documented():
    """Command -> key -> type, and whether it may be null: those of the sections whose headings name the command, of
    `every command` for all."""
    keys = defaultdict(dict)
    commands = []
    for line in PAGE.read_text(encoding="utf-8").splitlines():
        if line.startswith("## "):
            commands = re.findall(r"`([a-z]+)`", line) or (["*"] if "very command" in line else [])
        row = re.match(r"\| `([^`]+)` \| ([^|]+) \|(.*)", line)
        if row and commands:
            for command in commands:
                keys[command][row[1]] = (TYPES[row[2]], "`null`" in row[3])
    return keys


def wild(path, patterns):
    """The pattern `<label>` of the page stands for any key."""
    for pattern in patterns:
        parts = [re.escape(part) for part in re.split(r"<[a-z ]+>", pattern)]
        if len(parts) > 1 and re.fullmatch(".+?".join(parts), path):
            return pattern
    return path


def run(folder, arguments):
    return subprocess.run([PROGRAM, *arguments, "--json"], cwd=folder, stdout=subprocess.PIPE,
                          stderr=subprocess.PIPE, text=True)


def move_a_landmark(raw, scan, moved):
    """The table of landmarks of synthetic scans, the first of one scan a third of the way along its diagonal away."""
    ply = (raw / f"scans/{scan}.ply").read_bytes()
    count = int(re.search(rb"element vertex (\d+)", ply)[1])
    flat = struct.unpack_from(f"<{3 * count}d", ply, ply.index(b"end_header\n") + 11)
    vertices = list(zip(flat[::3], flat[1::3], flat[2::3]))
    diagonal = math.dist(*zip(*((min(axis), max(axis)) for axis in zip(*vertices))))
    lines = (raw / "landmarks.csv").read_text().splitlines()
    row = next(i for i, line in enumerate(lines) if line.startswith(scan + ","))
    cells = lines[row].split(",")
    place = [float(cell) for cell in cells[2:]]
    there = min(vertices, key=lambda vertex: abs(math.dist(vertex, place) - 0.3 * diagonal))
    lines[row] = ",".join(cells[:2] + [str(x) for x in there])
    moved.write_text("\n".join(lines) + "\n")


def main():
    keys = documented()
    printed = defaultdict(set)
    wrong = []
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        # A square of two triangles that face opposite ways; a tetrahedron whose corner occurs twice; a tetrahedron.
        (folder / "broken.obj").write_text("v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3\nf 1 3 9\n")
        (folder / "twice.obj").write_text(
            "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nv 0 0 0\nf 1 3 2\nf 5 2 4\nf 2 3 4\nf 3 1 4\n")
        (folder / "ball.obj").write_text("v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 2 3 4\nf 3 1 4\n")
        for arguments in RUNS:
            if "still0.ply" in arguments:  # four times one mesh, four times another
                for i in range(8):
                    kind = "happy" if i < 4 else "angry"
                    shutil.copy(folder / f"faces/s000_{kind}.ply", folder / f"still{i}.ply")
            if "marks.csv" in arguments:
                ply = (folder / "faces/s001_neutral.ply").read_bytes()
                x, y, z = struct.unpack_from("<3d", ply, ply.index(b"end_header\n") + 11 + 3 * 24)
                (folder / "marks.csv").write_text(f"scan,name,x,y,z,vertex\ns001_neutral,nose,{x},{y},{z},3\n")
            if "moved.csv" in arguments:
                move_a_landmark(folder / "raw", "s000_neutral", folder / "moved.csv")
            done = run(folder, arguments)
            command = arguments[0]
            without_page = command in ("explore", "report") and "without the page" in done.stderr
            failing = command == "check" and done.returncode == 3
            if "--keys" in sys.argv and not done.stdout:
                print(arguments, done.stderr)
                continue
            assert done.returncode == 0 or without_page or failing, (arguments, done.stderr)
            object_ = json.loads(done.stdout)
            if "--keys" in sys.argv:
                print(" ".join(arguments), sorted({path for path, _ in values_of(object_)}), sep="\n    ")
                continue
            assert list(object_)[:2] == ["command", "schema"], arguments
            assert object_["command"] == command and object_["schema"] == 1
            assert without_page or ("error" in object_) == failing, (arguments, object_.get("error"))
            allowed = keys[command] | keys["*"]
            for path, value in values_of(object_):
                path = wild(path, allowed)
                assert path in allowed, f"`shape {' '.join(arguments)}` prints {path}: not in docs/json.md"
                holds, may_be_null = allowed[path]
                if not (holds(value) or (value is None and may_be_null)):
                    wrong.append(f"`shape {' '.join(arguments)}` prints {path}: {json.dumps(value)[:80]}: of another type")
                printed[command].add(path)
            if without_page:
                printed[command] |= set(keys[command])
        assert not wrong, "docs/json.md has other types:\n" + "\n".join(wrong)
        # Failures: each kind that can be had, with the exit code, as one object on stdout and a line on stderr.
        (folder / "cut.h5").write_bytes((folder / "model.h5").read_bytes()[:3000])
        for arguments, code, kind, word in (
            (["stats", "faces.h5"], 2, "usage", "--output"),
            (["stats", "--nonsense"], 2, "usage", "nonsense"),
            (["nonsense"], 2, "usage", "nonsense"),
            ([], 2, "usage", ""),
            (["collect", "broken.obj", "-o", "x.h5"], 3, "input", "broken.obj"),
            (["info", "cut.h5"], 3, "input", "cut.h5"),
            (["info", "missing.h5"], 5, "file", "missing.h5"),
            (["stats", "faces.h5", "-o", "model.h5"], 5, "file", "--force"),
            (["generate", "model.h5", "--mode", "1", "--sigma", "-90:90:2", "--strict", "-o", "y"], 4, "numerical", ""),
        ):
            done = run(folder, arguments)
            assert done.returncode == code, (arguments, done)
            object_ = json.loads(done.stdout)
            assert object_["error"]["kind"] == kind and object_["error"]["exit_code"] == code
            assert word in object_["error"]["message"] and "shape: error: " in done.stderr
            assert object_["schema"] == 1
            known = arguments and arguments[0] != "nonsense"
            assert object_["command"] == (arguments[0] if known else None)
            printed["*"] |= {path for path, _ in values_of(object_)}
        # Help and version stay text.
        for arguments in (["--version"], ["stats", "--help"]):
            done = run(folder, arguments)
            assert done.returncode == (0 if arguments[0] == "stats" else done.returncode)
    for command, wanted in keys.items():
        here = set().union(*printed.values()) if command == "*" else printed[command]
        assert set(wanted) <= here, f"docs/json.md has keys of {command} that no run printed: {sorted(set(wanted) - here)}"
    print(f"{sum(len(found) for found in printed.values())} keys of {len(RUNS)} runs agree with docs/json.md")


main()
