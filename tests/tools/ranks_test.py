# SPDX-License-Identifier: MIT
"""Runs of the program by mpirun: the same bytes from 1, 2 and 4 processes, one line where one fails or is
killed, and --resume after that. Only where the program is built with MPI (-DSHAPE_WITH_MPI=ON)."""
import json
import os
import re
import signal
import subprocess
import tempfile
import time
from pathlib import Path

from ecosystem import PROGRAM

MPIRUN = [os.environ["SHAPE_MPIRUN"], "--quiet", "--oversubscribe"]
if os.geteuid() == 0:
    MPIRUN.append("--allow-run-as-root")


def shape(*arguments, processes=0):
    """(exit code, stdout, lines of stderr); 0 processes: without mpirun."""
    start = [*MPIRUN, "-n", str(processes)] if processes else []
    done = subprocess.run([*start, PROGRAM, *map(str, arguments)], capture_output=True, text=True, timeout=120)
    return done.returncode, done.stdout, done.stderr.splitlines()


def run(*arguments, processes=0):
    """The JSON that the program prints once."""
    code, out, err = shape(*arguments, "--json", "--quiet", processes=processes)
    assert code == 0 and not err, (arguments, processes, code, err)
    return json.loads(out)


def files_of(folder):
    return {path.relative_to(folder): path.read_bytes() for path in sorted(folder.rglob("*")) if path.is_file()}


def same_bytes_from_1_2_and_4():
    for name, command in [
            ("model.h5", ["stats", "c.h5", "--modes", "5", "-o"]),
            ("krylov.h5", ["stats", "c.h5", "--modes", "5", "--algorithm", "krylov", "-o"]),
            ("scores.csv", ["project", "model-1.h5", "c.h5", "-o"]),
            ("distances.csv", ["distance", "c.h5", "-o"]),
            ("quality.csv", ["quality", "c.h5", "--modes", "1,3", "--folds", "3", "--tests", "7", "--samples", "5", "-o"])]:
        results = []
        for processes in (1, 2, 4):
            output = Path(f"-{processes}.".join(name.split(".")))
            figures = run(*command, output, processes=processes)
            assert figures["outputs"] == [str(output)], figures
            results.append(output.read_bytes())
        assert results[0] == results[1] == results[2], f"{name} differs"


def meshes_are_shared_and_merged():
    run("stats", "c.h5", "--modes", "3", "-o", "few.h5")
    generate = ["generate", "few.h5", "--sample", "6", "-o"]
    run(*generate, "alone")
    weights = [word for share in ("0.25,0.75", "0.5,0.5", "0.75,0.25") for word in ("--weights", share)]
    pair = sorted(Path("faces").glob("*.ply"))[:2]
    run("interpolate", *pair, *weights, "-o", "blends")
    for processes in (2, 4):
        run(*generate, f"shared-{processes}", processes=processes)
        assert files_of(Path(f"shared-{processes}")) == files_of(Path("alone"))
    run("interpolate", *pair, *weights, "-o", "blends-2", processes=2)
    assert files_of(Path("blends-2")) == files_of(Path("blends"))
    run("fit", pair[0], *pair, "--keep-failed", "-o", "fits")
    run("fit", pair[0], *pair, "--keep-failed", "-o", "fits-2", processes=2)
    for mesh in pair:
        assert (Path("fits-2") / mesh.name).read_bytes() == (Path("fits") / mesh.name).read_bytes()
    assert not list(Path(".").glob("*.shard-*"))
    for arguments, word in [((*generate, "alone"), "exists already"),
                            ((*generate, "more", "--shard", "1/2"), "have a shard each"),
                            (("generate", "few.h5", "--sample", "1", "-o", "one"), "fewer than the 2 shards")]:
        code, _, err = shape(*arguments, processes=2)
        assert code in (2, 3, 5) and len(err) == 1 and word in err[0], (arguments, code, err)


def failures_end_in_a_line():
    damaged = bytearray(Path("c.h5").read_bytes())
    damaged[len(damaged) // 2] ^= 1
    Path("damaged.h5").write_bytes(damaged)
    for arguments, processes, expected, word in [
            (["stats", "c.h5", "-o", "x.h5"], 3, 2, "power of two"),
            (["info", "c.h5"], 2, 2, "runs in one process"),
            (["stats", "faces", "-o", "x.h5"], 2, 2, "one collection file"),
            (["stats", "damaged.h5", "-o", "x.h5"], 2, 3, "the stored values of rows"),
            (["distance", "damaged.h5", "-o", "x.csv"], 4, 3, "the stored values of rows")]:
        code, _, err = shape(*arguments, processes=processes)
        assert code == expected and len(err) == 1 and word in err[0], (arguments, code, err)
    assert not Path("x.h5").exists() and not Path("x.csv").exists()


def children(process):
    """Its processes of the program, in the order of their numbers."""
    found = subprocess.run(["pgrep", "-P", str(process.pid)], capture_output=True, text=True)
    return sorted(map(int, found.stdout.split()))


def stop_one(number, how, command, output):
    """Starts four processes and stops one as soon as a state is kept. None if they were quicker."""
    process = subprocess.Popen([*MPIRUN, "-n", "4", PROGRAM, *command], stderr=subprocess.PIPE, text=True)
    state = Path(f"{output}.unfinished")
    while not state.exists() and process.poll() is None:
        time.sleep(0.001)
    some = children(process)
    if process.poll() is not None or len(some) != 4:
        process.communicate()
        return None
    os.kill(some[number], how)
    _, err = process.communicate(timeout=60)
    if process.returncode == 0:
        return None
    assert state.exists() and not output.exists()
    # OpenMPI may add what it could not read of a lost partner: [machine:process] Read -1, ...
    return process.returncode, [line for line in err.splitlines() if not re.match(r"\[\S+:\d+\] ", line)]


def a_killed_process_ends_the_run_and_it_is_resumed():
    # Little memory: many passes, with a state after each.
    command = ["stats", "long.h5", "--modes", "4", "--algorithm", "gram", "--memory", "16M",
               "--save-every", "1e-9", "-o"]
    run(*command, "whole.h5", processes=4)
    for number, how in [(0, signal.SIGKILL), (3, signal.SIGKILL), (1, signal.SIGTERM)]:
        output = Path(f"stopped-{number}.h5")
        for _ in range(10):
            stopped = stop_one(number, how, [*command, output], output)
            if stopped:
                break
            output.unlink(missing_ok=True)
        assert stopped, "the run was always quicker"
        code, err = stopped
        assert code == (128 + signal.SIGKILL if how == signal.SIGKILL else 130), (number, code, err)
        assert len(err) == 1 and "interrupted;" in err[0] and "--resume goes on" in err[0], (number, err)
        figures = run(*command, output, "--resume", processes=2)
        assert figures["passes"] > 2
        assert output.read_bytes() == Path("whole.h5").read_bytes(), f"resumed after {how} of {number}"


def main():
    with tempfile.TemporaryDirectory() as folder:
        os.chdir(folder)
        run("synth", "faces", "--count", "14", "--vertices", "300", "-o", "faces")
        run("collect", "faces", "-o", "c.h5")
        run("synth", "faces", "--count", "170", "--vertices", "2500", "-o", "many")
        run("collect", "many", "-o", "long.h5")
        same_bytes_from_1_2_and_4()
        meshes_are_shared_and_merged()
        failures_end_in_a_line()
        a_killed_process_ends_the_run_and_it_is_resumed()


main()
