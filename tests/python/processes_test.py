# SPDX-License-Identifier: MIT
"""The package where processes fork, are interrupted, and read files that may crash them."""
import multiprocessing
import os
import pickle
import signal
import subprocess
import sys
import tempfile
import time
import unittest
from pathlib import Path
from unittest import mock

import numpy as np

import libshape as ls
from libshape import _files

DATA = Path(os.environ.get("SHAPE_DATA_DIR", Path(os.environ["SHAPE_SOURCE"]) / "../shared/data"))
LIMIT = 60  # [s] after which a child has hung

faces = ls.synthetic("faces", count=4, vertices=400)
model = faces.model(modes=5)


def everything(seed: int) -> np.ndarray:
    """Work of every kind: loops, products of matrices, factorisations."""
    mesh, _ = model.decode([seed, 1.0])
    own = faces.model(modes=3)
    ls.groups(faces, "expression", permutations=99)
    return np.concatenate([mesh.V.ravel(), np.abs(own.scores(faces).scores).ravel()])


class Forks(unittest.TestCase):
    def setUp(self) -> None:
        self.threads = ls.thread_count()
        ls.set_thread_count(3)  # helpers that a child will not have, on any machine

    def tearDown(self) -> None:
        ls.set_thread_count(self.threads)

    def test_a_child_works_as_its_parent_does(self) -> None:
        wanted = everything(1)
        for _ in range(3):
            child = os.fork()
            if child == 0:
                code = 1
                try:
                    signal.alarm(LIMIT)
                    code = 0 if np.array_equal(everything(1), wanted) else 2
                finally:
                    os._exit(code)
            self.assertEqual(os.waitpid(child, 0)[1], 0)
            np.testing.assert_array_equal(everything(1), wanted)

    def test_a_child_may_end_as_interpreters_do(self) -> None:
        program = (
            "import os, signal, sys, libshape as ls\n"
            "ls.set_thread_count(3)\n"
            "c = ls.synthetic('faces', count=2, vertices=300)\n"
            "c.model()\n"
            "child = os.fork()\n"
            "if child == 0:\n"
            f"    signal.alarm({LIMIT})\n"
            "c.model()\n"
            "if child == 0:\n"
            "    sys.exit(0)\n"
            "sys.exit(os.waitpid(child, 0)[1] != 0)\n"
        )
        subprocess.run([sys.executable, "-c", program], check=True, timeout=2 * LIMIT)

    def test_pools_of_processes(self) -> None:
        wanted = [everything(seed) for seed in range(4)]
        with multiprocessing.get_context("fork").Pool(2) as pool:
            for found, right in zip(pool.map_async(everything, range(4)).get(timeout=LIMIT), wanted):
                np.testing.assert_array_equal(found, right)


class Interrupts(unittest.TestCase):
    """Ctrl-C ends the work itself, not only the wait: the interpreter can end."""

    def test_work_stops(self) -> None:
        for work in (
            "ls.groups(c, 'expression', permutations=10**7)",
            "ls.groups(c, 'expression', permutations=0, replicates=10**7)",
            "ls.synthetic('faces', count=9000, vertices=20000)",
            "ls.fit(big[0], big[1], smoothness=2.0)",
        ):
            # The interpreter takes no turn from a thread: the other one speaks only when the first waits for its work.
            program = (
                "import libshape as ls, sys, threading\n"
                "c = ls.synthetic('faces', count=8, vertices=300)\n"
                "big = ls.synthetic('faces', count=1, vertices=20000)\n"
                "sys.setswitchinterval(1000)\n"
                "go = threading.Event()\n"
                "threading.Thread(target=lambda: go.wait() and print('at work', flush=True)).start()\n"
                "try:\n"
                "    go.set()\n"
                f"    {work}\n"
                "except KeyboardInterrupt:\n"
                "    sys.exit(3)\n"
            )
            process = subprocess.Popen([sys.executable, "-c", program], stdout=subprocess.PIPE, text=True)
            self.assertEqual(process.stdout.readline(), "at work\n")
            sent = time.time()
            process.send_signal(signal.SIGINT)
            try:
                self.assertEqual(process.wait(timeout=LIMIT), 3, work)
            finally:
                process.kill()
                process.stdout.close()
            print(f"{work}: the interpreter ended {1000 * (time.time() - sent):.0f} ms after Ctrl-C")


class Files(unittest.TestCase):
    def setUp(self) -> None:
        scratch = tempfile.TemporaryDirectory()
        self.addCleanup(scratch.cleanup)
        self.folder = Path(scratch.name)

    def test_untrusted_files_are_read_apart(self) -> None:
        path = self.folder / "model.h5"
        model.write(path)
        np.testing.assert_array_equal(ls.read_model(path, untrusted=True).modes, model.modes)
        faces.write(self.folder / "c.h5")
        again = ls.read(self.folder / "c.h5", untrusted=True)
        self.assertEqual([mesh.name for mesh in again], [mesh.name for mesh in faces])
        with self.assertRaises(FileNotFoundError):
            ls.read_model(self.folder / "none.h5", untrusted=True)
        path.write_bytes(path.read_bytes()[:5000])
        with self.assertRaises(ls.InvalidInput):
            ls.read_model(path, untrusted=True)

    def test_what_crashes_its_reader_is_refused(self) -> None:
        hostile = sorted((DATA / "hostile").glob("*.h5"))
        for path in hostile:
            for read in (ls.read_model, ls.read_difference, lambda path, untrusted: ls.read([path], untrusted=untrusted)):
                with self.assertRaisesRegex(ls.InvalidInput, f"{path.name}: the HDF5 file is damaged"):
                    read(path, untrusted=True)
        if not hostile:
            self.skipTest("no data")

    def test_isolation_lasts_as_long_as_the_last_who_asked(self) -> None:
        with mock.patch.object(_files._core, "isolate_hdf5_files") as isolate:
            with _files.isolated(True):
                with _files.isolated(False), _files.isolated(True):
                    pass
                self.assertEqual(isolate.call_args, mock.call(True))
            self.assertEqual(isolate.call_args, mock.call(False))
        with mock.patch.object(_files._core, "isolate_hdf5_files") as isolate:
            with self.assertRaises(ls.InvalidInput), _files.isolated(True):
                raise ls.InvalidInput("x")
            self.assertEqual(isolate.call_args, mock.call(False))

    def test_objects_go_to_other_processes(self) -> None:
        smile = ls.difference(faces, "expression=neutral", "expression=happy", pair_by="subject")
        for thing, arrays in (
            (faces, lambda c: [mesh.V for mesh in c] + [c.F]),
            (model, lambda m: [m.modes, m.mean, m.variances, m.training_scores, m.F]),
            (smile, lambda d: [d.lengths, d.dihedral_angles, d.F]),
        ):
            copy = pickle.loads(pickle.dumps(thing))
            self.assertEqual(repr(copy), repr(thing))
            for found, wanted in zip(arrays(copy), arrays(thing)):
                np.testing.assert_array_equal(found, wanted)
        self.assertEqual(pickle.loads(pickle.dumps(faces)).labels, faces.labels)


if __name__ == "__main__":
    unittest.main(verbosity=1)
