# SPDX-License-Identifier: MIT
"""The Python package against the program, and by itself."""
import csv
import gc
import json
import os
import signal
import subprocess
import sys
import tempfile
import threading
import time
import unittest
import warnings
from pathlib import Path
from types import SimpleNamespace
from typing import Callable, List

import numpy as np

import libshape as ls
from ecosystem import PROGRAM, shape
from libshape import _core


class WithFaces(unittest.TestCase):
    """A folder with the meshes, the collection and the model that the program makes."""

    @classmethod
    def setUpClass(cls) -> None:
        cls.scratch = tempfile.TemporaryDirectory()
        cls.folder = Path(cls.scratch.name)
        shape(cls.folder, "synth", "faces", "-o", "faces", "--count", "4", "--vertices", "400")
        shape(cls.folder, "collect", "faces", "--labels", "faces/labels.csv", "-o", "faces.h5")
        shape(cls.folder, "stats", "faces.h5", "-o", "model.h5", "--modes", "5")
        cls.faces = ls.read(cls.folder / "faces", labels=cls.folder / "faces/labels.csv")
        cls.model = cls.faces.model(modes=5)

    @classmethod
    def tearDownClass(cls) -> None:
        cls.scratch.cleanup()

    def mesh_of_program(self, *arguments: str) -> ls.Mesh:
        shape(self.folder, *arguments, "-o", "x.ply", "--force")
        return ls.read_mesh(self.folder / "x.ply")


class SameBitsAsTheProgram(WithFaces):
    def test_reading(self) -> None:
        file = ls.read(self.folder / "faces.h5")
        self.assertEqual(file.names, self.faces.names)
        self.assertEqual(file.labels, self.faces.labels)
        for a, b in zip(file, self.faces):
            np.testing.assert_array_equal(a.V, b.V)
            np.testing.assert_array_equal(a.F, b.F)
        self.assertEqual(len(self.faces), 12)

    def test_model_files(self) -> None:
        self.model.write(self.folder / "ours.h5")
        self.assertEqual(
            (self.folder / "ours.h5").read_bytes(), (self.folder / "model.h5").read_bytes()
        )
        self.faces.write(self.folder / "collection.h5")
        self.assertEqual(
            (self.folder / "collection.h5").read_bytes(), (self.folder / "faces.h5").read_bytes()
        )
        read = ls.read_model(self.folder / "model.h5")
        np.testing.assert_array_equal(read.modes, self.model.modes)

    def test_models_with_positions(self) -> None:
        self.faces.model(modes=5, with_positions=5).write(self.folder / "ours.h5")
        shape(
            self.folder, "stats", "faces.h5", "-o", "placed.h5", "--modes", "5", "--with-positions", "5"
        )
        self.assertEqual(
            (self.folder / "ours.h5").read_bytes(), (self.folder / "placed.h5").read_bytes()
        )

    def test_decoding(self) -> None:
        mesh, report = self.model.decode([-2, 1, 0])
        wanted = self.mesh_of_program("generate", "model.h5", "--scores=-2,1,0")
        np.testing.assert_array_equal(mesh.V, wanted.V)
        self.assertEqual(report.status, "exact" if report.edge_max <= 1e-6 else report.status)
        self.assertLess(report.edge_rms, 0.01)
        mesh, _ = self.model.decode([], size=3.0)
        wanted = self.mesh_of_program("generate", "model.h5", "--mean", "--size", "3")
        np.testing.assert_array_equal(mesh.V, wanted.V)

    def test_samples(self) -> None:
        meshes, _ = self.model.decode_all(self.model.sample(2, seed=7), quality="preview")
        shape(self.folder, "generate", "model.h5", "--sample", "2", "--seed", "7", "--quality",
              "preview", "-o", "samples", "--quiet")
        for mesh, wanted in zip(meshes, ls.read(self.folder / "samples")):
            np.testing.assert_array_equal(mesh.V, wanted.V)

    def test_scores(self) -> None:
        shape(self.folder, "project", "model.h5", "faces.h5", "-o", "scores.csv")
        with open(self.folder / "scores.csv", encoding="utf-8") as file:
            wanted = list(csv.DictReader(file))
        found = self.model.scores(self.faces).as_dict()
        self.assertEqual(list(found), list(wanted[0]))
        for i, row in enumerate(wanted):
            for column, cell in row.items():
                value = found[column][i]
                self.assertEqual(value, cell if isinstance(value, str) else float(cell))
        single = self.model.scores(self.faces[3].V)
        np.testing.assert_allclose(  # a sum over a row alone may be added up in another order
            single.scores, self.model.scores(self.faces).scores[3], rtol=0, atol=1e-15
        )
        np.testing.assert_allclose(
            self.model.scores(self.model.decode([1.5, -1])[0]).deviations[:2], [1.5, -1], atol=0.1
        )

    def test_interpolation(self) -> None:
        frames = ls.interpolate(self.faces[0], self.faces[1], frames=4)
        names = [f"faces/{self.faces.names[i]}.ply" for i in (0, 1)]
        shape(self.folder, "interpolate", *names, "--frames", "4", "-o", "frames")
        for frame, wanted in zip(frames, ls.read(self.folder / "frames")):
            np.testing.assert_array_equal(frame.V, wanted.V)
            self.assertEqual(frame.name, wanted.name)
        blend = ls.interpolate(*self.faces[[0, 1, 2]], weights=[[0.25, 0.25, 0.5]])
        wanted = self.mesh_of_program(
            "interpolate", *names, f"faces/{self.faces.names[2]}.ply", "--weights", "0.25,0.25,0.5"
        )
        np.testing.assert_array_equal(blend[0].V, wanted.V)
        frames.write(self.folder / "frames.glb", tolerance=1e-9)
        self.assertEqual(len(ls.read(self.folder / "frames.glb")), 4)

    def test_frames_of_paths(self) -> None:
        """31 frames and more are a motion, whose neighbours agree on folds; fewer are blends of their own."""
        for meshes, count, options in (
            (2, 5, {}), (2, 30, {}), (2, 31, {}), (3, 31, {}), (2, 61, {}), (2, 31, {"quality": "preview"}),
            (2, 31, {"squared": True}), (2, 31, {"smoothness": 0.02}), (2, 31, {"avoid_contact": True}),
            (2, 3, {"squared": True}), (2, 3, {"method": "closure"}),
        ):
            more = ["--lengths", "squared"] if "squared" in options else []
            more += ["--avoid-contact"] if "avoid_contact" in options else []
            for option in ("quality", "smoothness", "method"):
                more += [f"--{option}", str(options[option])] if option in options else []
            names = [f"faces/{name}.ply" for name in self.faces.names[:meshes]]
            shape(self.folder, "interpolate", *names, "--frames", str(count), *more, "-o", f"of{count}", "--force",
                  "--quiet")
            frames = ls.interpolate(self.faces[:meshes], frames=count, **options)
            with self.subTest(meshes=meshes, count=count, **options):
                self.assertEqual(len(frames), count)
                for i, frame in enumerate(frames):
                    wanted = ls.read_mesh(self.folder / f"of{count}/frame_{i:04}.ply")
                    np.testing.assert_array_equal(frame.V, wanted.V)
        # Which of the two it is: a blend at the same place is the same mesh, or another.
        weights = [[1.0 - t, t] for t in (0.2, 0.4)]
        alone = [ls.edges(mesh).lengths for mesh in ls.interpolate(self.faces[:2], weights=weights)]
        for count, same in ((6, True), (31, False)):
            frames = ls.interpolate(self.faces[:2], frames=count)
            for t, lengths in zip((0.2, 0.4), alone):
                found = ls.edges(frames[round(t * (count - 1))]).lengths
                self.assertEqual(np.allclose(found, lengths, rtol=1e-9, atol=0), same)

    def test_seeds_of_patches(self) -> None:
        def of_program(seed: int, *arguments: str) -> np.ndarray:
            return self.mesh_of_program(*arguments, "--method", "multiscale", "--seed", str(seed)).V

        a, b = self.faces[0], self.faces[1]
        smile = ls.difference(self.faces, "expression=neutral", "expression=happy", pair_by="subject")
        smile.write(self.folder / "seeded.h5")
        found = []
        for seed in (1, 5):
            options = {"method": "multiscale", "seed": seed}
            mesh = self.model.decode([1, -1], **options)[0]
            np.testing.assert_array_equal(mesh.V, of_program(seed, "generate", "model.h5", "--scores=1,-1"))
            np.testing.assert_array_equal(self.model.decode_all([[1, -1]], **options)[0][0].V, mesh.V)
            np.testing.assert_array_equal(
                ls.interpolate(a, b, weights=[[0.5, 0.5]], **options)[0].V,
                of_program(seed, "interpolate", f"faces/{a.name}.ply", f"faces/{b.name}.ply", "--weights", "0.5,0.5"),
            )
            shape(self.folder, "difference", "--load", "seeded.h5", "--onto", f"faces/{a.name}.ply", "--method",
                  "multiscale", "--seed", str(seed), "--mesh", "onto.ply", "--force", "--quiet")
            np.testing.assert_array_equal(smile.apply(a, **options)[0].V, ls.read_mesh(self.folder / "onto.ply").V)
            found.append(mesh.V)
        self.assertFalse(np.array_equal(*found))
        np.testing.assert_array_equal(self.model.decode([1], seed=5)[0].V, self.model.decode([1])[0].V)

    def test_meshes_without_contact(self) -> None:
        for scores in ([-2, 1, 0], [9, -9, 9]):
            plain = self.model.decode(scores)[1]
            self.assertIsNone(plain.avoidable_self_intersections)
            mesh, report = self.model.decode(scores, avoid_contact=True)
            wanted = self.mesh_of_program(
                "generate", "model.h5", "--scores=" + ",".join(map(str, scores)), "--avoid-contact"
            )
            np.testing.assert_array_equal(mesh.V, wanted.V)
            self.assertEqual(report.avoidable_self_intersections, plain.new_self_intersections)

    def test_differences(self) -> None:
        pairs = ["--pair-by", "subject", "--from", "expression=neutral", "--to", "expression=happy"]
        shape(self.folder, "difference", "faces.h5", *pairs, "-o", "d.h5", "--mesh", "applied.ply",
              "--apply", "--amount", "1.5", "--force")
        smile = ls.difference(
            self.faces, "expression=neutral", "expression=happy", pair_by="subject"
        )
        np.testing.assert_array_equal(
            smile.apply(amount=1.5)[0].V, ls.read_mesh(self.folder / "applied.ply").V
        )
        smile.write(self.folder / "ours_d.h5")
        np.testing.assert_array_equal(
            ls.read_difference(self.folder / "ours_d.h5").lengths, smile.lengths
        )
        shape(self.folder, "difference", "--load", "d.h5", "--onto", f"faces/{self.faces.names[2]}.ply",
              "--mesh", "onto.ply", "--force")
        np.testing.assert_array_equal(
            smile.apply(self.faces[2])[0].V, ls.read_mesh(self.folder / "onto.ply").V
        )
        self.assertEqual(len(smile.pairs), 4)

    def test_fits(self) -> None:
        template = self.faces["s000_neutral"]
        scan = ls.synthetic("faces", count=1, vertices=700, seed=9)["s000_happy"]
        scan.write(self.folder / "raw.ply")
        template.write(self.folder / "template.ply")
        # Landmarks by vertex and by place, those of the program's table.
        nearest = [int(np.argmin(np.linalg.norm(scan.V - template.V[v], axis=1))) for v in (20, 90, 200, 310)]
        rows = [f"raw,mark{i},{x!r},{y!r},{z!r}" for i, (x, y, z) in enumerate(scan.V[nearest].tolist())]
        rows += [f"template,mark{i},{x!r},{y!r},{z!r}"
                 for i, (x, y, z) in enumerate(template.V[[20, 90, 200, 310]].tolist())]
        (self.folder / "marks.csv").write_text("scan,name,x,y,z\n" + "\n".join(rows) + "\n")
        marks = {f"mark{i}": (v, scan.V[n]) for i, (v, n) in enumerate(zip((20, 90, 200, 310), nearest))}
        for options, landmarks, more in (
            ([], None, {}),
            (["--landmarks", "marks.csv", "--smoothness", "2", "--landmark-tolerance", "0.5"], marks,
             {"smoothness": 2.0, "landmark_tolerance": 0.5}),
        ):
            printed = json.loads(shape(self.folder, "fit", "template.ply", "raw.ply", "-o", "fits", "--force",
                                       "--json", *options))["scans"][0]
            wanted = ls.read_mesh(self.folder / "fits/raw.ply").V
            for given in (scan, self.folder / "raw.ply"):
                mesh, report = ls.fit(template, given, landmarks, **more)
                np.testing.assert_array_equal(mesh.V, wanted)
                np.testing.assert_array_equal(mesh.F, template.F)
                self.assertEqual(report.status, printed["status"])
                self.assertEqual(report.reasons, printed["reasons"])
                self.assertEqual(report.scan_to_fit.mean, printed["scan_to_fit"]["mean"])
                self.assertEqual(report.fit_to_scan.max, printed["fit_to_scan"]["max"])
                self.assertEqual(report.growth_high, printed["growth_high"])
                self.assertEqual(report.unclaimed_share, printed["unclaimed_share"])
                self.assertEqual(report.contested_vertices, printed["contested_vertices"])
                self.assertEqual(int((~report.seen).sum()), printed["unseen_vertices"])
                self.assertEqual(len(report.landmark_errors), printed["landmarks"])
                self.assertEqual(report.landmarks, list(landmarks or {}))
                self.assertEqual(report.doubted_landmarks,
                                 {mark["landmark"]: mark["off"] for mark in printed["doubted_landmarks"]})
                self.assertEqual(report.distance.shape, (len(template.V),))
        self.assertIn("FitReport(good: scan to fit ", repr(report))
        self.assertEqual(ls.fit(template, scan)[0].name, "s000_happy")

    def test_groups_and_distances(self) -> None:
        shape(self.folder, "groups", "faces.h5", "--by", "expression", "--within", "subject", "-o",
              "groups.csv", "--force", "--quiet")
        with open(self.folder / "groups.csv", encoding="utf-8") as file:
            rows = list(csv.DictReader(file))
        found = ls.groups(self.faces, "expression", within="subject")
        self.assertEqual(found.overall.f, float(rows[0]["f"] if "f" in rows[0] else rows[0]["F"]))
        self.assertEqual(found.overall.p_value, float(rows[0]["p_value"]))
        for pair, row in zip(found.pairs, rows[1:]):
            self.assertEqual((pair.first, pair.second), (row["first"], row["second"]))
            self.assertEqual(pair.distance, float(row["distance"]))
            self.assertEqual(pair.adjusted_p, float(row["p_adjusted"]))
        for metric in ("edge", "edge-unit", "procrustes"):
            shape(self.folder, "distance", "faces.h5", "--metric", metric, "-o", "m.csv", "--force",
                  "--quiet")
            wanted = np.loadtxt(
                self.folder / "m.csv", delimiter=",", skiprows=1, usecols=range(1, 13)
            )
            np.testing.assert_array_equal(ls.distance(self.faces, metric).matrix, wanted)

    def test_any_number_of_threads(self) -> None:
        before = ls.thread_count()
        wanted = self.model.decode([1, 1])[0].V
        for count in (1, 3):
            ls.set_thread_count(count)
            np.testing.assert_array_equal(
                self.faces.model(modes=5).decode([1, 1])[0].V, wanted
            )
        ls.set_thread_count(before)


class Arguments(WithFaces):
    def test_kinds_that_are_taken(self) -> None:
        V, F = self.faces[0]
        wanted = ls.edges((V, F))
        for mesh in (
            self.faces[0],
            [V.tolist(), F.tolist()],
            (np.asfortranarray(V), F.astype(np.int32)),
            SimpleNamespace(vertices=V, faces=F),
            SimpleNamespace(points=V, cells_dict={"triangle": F.astype(np.uint64)}),
            SimpleNamespace(points=V, regular_faces=F),
        ):
            np.testing.assert_array_equal(ls.edges(mesh).lengths, wanted.lengths)
        single = ls.edges((V.astype(np.float32), F))
        np.testing.assert_allclose(single.lengths, wanted.lengths, rtol=1e-5)
        ends = V[wanted.ends]
        np.testing.assert_allclose(
            wanted.lengths, np.linalg.norm(ends[:, 0] - ends[:, 1], axis=1), rtol=1e-14
        )

    def test_errors_name_argument_and_shape(self) -> None:
        V, F = self.faces[0]
        for run, words in (
            (lambda: ls.Mesh(V[:, :2], F), r"V: shape must be \(n, 3\), is \(\d+, 2\)"),
            (lambda: ls.Mesh(V, F.ravel()), r"F: shape must be \(m, 3\), is \(\d+,\)"),
            (lambda: ls.Mesh(V, F.astype(float)), "F: must hold integers, holds float64"),
            (lambda: ls.Mesh("abc", F), "V: must be an array of numbers, is str"),
            (lambda: ls.Mesh(V.astype(complex), F), "V: must be an array of numbers, is ndarray of dtype complex128"),
            (lambda: ls.interpolate((V, F), (V, F), frames=0), "frames is 0, weights are not given; give one"),
            (lambda: ls.Mesh([[0, 0, 0], [1, 2]], F), "V: must be an array of numbers, is list"),
            (lambda: ls.fit((V, F), (V, F), {"nose": (0, [1, 2])}),
             r"landmarks\['nose'\]: shape must be \(3,\), is \(2,\)"),
            (lambda: ls.fit((V, F), (V, F[0])), r"scan.F: shape must be"),
            (lambda: ls.edges(3), r"mesh: must be a Mesh or a pair \(V, F\), is int"),
            (lambda: ls.collection([(V, F), (V.T, F)]), r"meshes\[1\].V: shape must be"),
            (lambda: ls.collection([V, V[0]], F), r"meshes\[1\]: shape must be \(n, 3\), is \(3,\)"),
            (lambda: self.model.decode([[1, 2]]), r"scores: shape must be \(k,\), is \(1, 2\)"),
            (lambda: self.model.scores(V.ravel()), r"V: shape must be \(n, 3\)"),
            (lambda: ls.interpolate((V, F), (V, F), weights=[[1.0]]), r"weights: shape must be \(frames, 2\)"),
            (lambda: ls.interpolate((V, F), (V, F)), "frames, weights"),
            (lambda: ls.difference(self.faces, "neutral", "a=b"), "from_: must be 'LABEL=VALUE'"),
            (lambda: ls.read(self.folder / "faces", progress=3), "progress"),
            (lambda: self.faces[0].write("x.ply", colors=V), r"colors: must be uint8 of shape \(n, 3\)"),
        ):
            with self.subTest(words), self.assertRaisesRegex(TypeError, words):
                run()

    def test_errors_of_the_library_are_errors_of_python(self) -> None:
        V, F = self.faces[0]
        for run, kind, words in (
            (lambda: ls.read("nowhere.ply"), OSError, "nowhere.ply"),
            (lambda: ls.read(__file__), ValueError, "ending of a mesh file"),
            (lambda: ls.collection([(V, F[:, [0, 2, 1]]), (V, F)]), ValueError,
             r"meshes\[1\]: face 0 is .*, in meshes\[0\] it is .*inside out: reverse its faces"),
            (lambda: self.faces.model(modes=99), ls.InvalidInput, "modes"),
            (lambda: self.faces.model(space="flat"), ls.InvalidInput, "space: 'flat'"),
            (lambda: self.model.decode(np.zeros(99)), ls.InvalidInput, "99 given, the model has 5"),
            (lambda: self.model.decode([0], method="magic"), ls.InvalidInput, "'magic'"),
            (lambda: self.model.scores(V[:-1]), ls.InvalidInput, "vertices"),
            (lambda: self.model.scores(V * np.nan), ls.InvalidInput, "not finite"),
            (lambda: ls.distance(self.faces, "city"), ls.InvalidInput, "metric"),
            (lambda: ls.groups(self.faces, "age"), ls.InvalidInput, "age"),
            (lambda: ls.fit((V, F), (V, F), {"nose": (len(V), V[0])}), ls.InvalidInput,
             r"landmarks\['nose'\]: vertex \d+ is not among the template's"),
            (lambda: ls.fit((V, F), (V, F), smoothness=0.0), ls.InvalidInput, "smoothness"),
            (lambda: ls.fit((V, F), (V, F), boundaries=["mouth"]), ls.InvalidInput, "mouth"),
            (lambda: ls.fit((V, F), "missing.ply"), ls.FileError, "missing.ply"),
            (lambda: ls.Mesh(V, F + 10**9).write("x.ply"), ls.InvalidInput, "faces"),
            (lambda: ls.Mesh(V, F - 10**9).write("x.ply"), ls.InvalidInput, "F: row 0"),
        ):
            with self.subTest(words), self.assertRaisesRegex(kind, words) as caught:
                run()
            self.assertIsInstance(caught.exception, ls.Error)
        with self.assertRaises(KeyError):
            self.faces["nobody"]
        with self.assertRaises(IndexError):
            self.faces[12]

    def test_collections_from_memory(self) -> None:
        labels = {"age": [1, 2, 3]}
        made = ls.collection([m.V for m in self.faces[:3]], self.faces.F, names=["a", "b", "c"],
                             labels=labels)
        self.assertEqual((made.names, made.labels), (("a", "b", "c"), {"age": ("1", "2", "3")}))
        self.assertEqual(made[-1].name, "c")
        self.assertEqual(made[::-2].names, ("c", "a"))
        np.testing.assert_array_equal(made["b"].V, self.faces[1].V)
        self.assertEqual(tuple(m.name for m in made), made.names)


class Behaviour(WithFaces):
    def test_large_arrays_are_not_copied(self) -> None:
        V, F = self.faces[0]
        mesh = ls.Mesh(V, F)
        self.assertIs(mesh.V, V)
        self.assertIs(mesh.F, F)
        for a, b in ((self.faces[0].V, V), (self.model.modes, self.model.modes)):
            self.assertEqual(a.ctypes.data, b.ctypes.data)
            self.assertFalse(a.flags.writeable)
        points, _ = self.model.decode([0])[0]
        self.assertFalse(points.flags.owndata)  # the library's own memory
        self.assertTrue(points.flags.writeable)

    def test_views_outlive_what_they_look_into(self) -> None:
        model = self.faces.model(modes=3)
        modes = model.modes
        wanted = modes.copy()
        V = ls.read(self.folder / "faces.h5")[2].V
        del model
        gc.collect()
        np.testing.assert_array_equal(modes, wanted)
        np.testing.assert_array_equal(V, self.faces[2].V)

    def test_other_threads_run_meanwhile(self) -> None:
        go = threading.Event()

        def interrupt() -> None:
            go.wait()
            os.kill(os.getpid(), signal.SIGINT)

        # The interpreter takes no turn from the waiting thread: the other one runs only if that gives its up.
        interval = sys.getswitchinterval()
        other = threading.Thread(target=interrupt)
        other.start()
        sys.setswitchinterval(1000)
        try:
            with self.assertRaises(KeyboardInterrupt):
                go.set()
                _core.wait(100, 0.1, None)
        finally:
            sys.setswitchinterval(interval)
        other.join()

    def test_interrupts_end_the_wait_at_once(self) -> None:
        program = (
            "import libshape._core as c, sys, time\n"
            "try:\n"
            "    print('ready', flush=True)\n"
            "    c.wait(60, float(sys.argv[1]), None)\n"
            "except KeyboardInterrupt:\n"
            "    print(time.time(), flush=True)\n"
        )
        for step in ("0.01", "1.5"):  # the second looks up too seldom to be asked
            process = subprocess.Popen(
                [sys.executable, "-c", program, step], stdout=subprocess.PIPE, text=True
            )
            self.assertEqual(process.stdout.readline(), "ready\n")
            sent = time.time()
            process.send_signal(signal.SIGINT)
            took = float(process.stdout.readline()) - sent
            self.assertEqual(process.wait(timeout=20), 0)
            process.stdout.close()
            print(f"Ctrl-C with looks every {step} s: KeyboardInterrupt after {1000 * took:.0f} ms")

    def test_progress_is_told_in_the_thread_that_waits(self) -> None:
        calls = []
        me = threading.get_ident()

        def told(stage: str, done: int, total: int) -> None:
            self.assertEqual(threading.get_ident(), me)
            calls.append((stage, done, total))

        ls.interpolate(self.faces[0], self.faces[1], frames=5, progress=told)
        self.assertEqual(calls[-1], ("embedding", 5, 5))
        with self.assertRaisesRegex(ZeroDivisionError, "enough"):
            def fail(*_: object) -> None:
                raise ZeroDivisionError("enough")
            _core.wait(5.0, 0.01, fail)

    def test_results_tell_what_they_are(self) -> None:
        mesh, report = self.model.decode([1])
        for thing, words in (
            (mesh, r"Mesh\('scores', \d+ vertices, \d+ faces\)"),
            (report, r"Report\(\w+: edge errors RMS .* % of the mean length, largest .* % of .* own; dihedral angles .* deg RMS"),
            (self.faces, r"Collection\(12 meshes, \d+ vertices, \d+ faces, labels .*expression"),
            (self.model, r"Model\(edge space, 5 modes with .* % of the variance of 12 meshes"),
            (self.model.scores(self.faces), r"Scores\(12 meshes in 5 modes\)"),
            (ls.distance(self.faces), r"Distances\(12 meshes, largest "),
            (ls.edges(mesh), r"Edges\(\d+, mean length "),
            (ls.groups(self.faces, "expression", permutations=9), r"Groups\(.*neutral \(4\).*p = "),
            (ls.difference(self.faces, "expression=happy", "expression=angry"), r"Difference\("),
            (ls.interpolate(mesh, self.faces[1], frames=2), r"Frames\(2 meshes"),
        ):
            self.assertRegex(repr(thing), words)

    def warnings_of(self, act: Callable[[], object]) -> List[str]:
        with warnings.catch_warnings(record=True) as caught:
            warnings.simplefilter("always")
            act()
        for warning in caught:
            self.assertEqual(Path(warning.filename).name, Path(__file__).name)
        return [str(warning.message) for warning in caught]

    def test_meshes_unlike_those_of_a_model_are_named_as_by_the_program(self) -> None:
        sound = self.faces[0]
        mirror = ls.Mesh(sound.V * [-1, 1, 1], sound.F, "mirror")
        large = ls.Mesh(1000 * sound.V, sound.F, "large")
        said = self.warnings_of(lambda: self.model.scores(mirror))
        for mesh in (mirror, large):
            mesh.write(self.folder / f"{mesh.name}.ply")
        program = subprocess.run(
            [PROGRAM, "project", "model.h5", "mirror.ply", "large.ply", "-o", "unlike.csv"],
            cwd=self.folder,
            stderr=subprocess.PIPE,
            text=True,
        ).stderr
        self.assertEqual(len(said), 1)
        self.assertIn("mirror bends the other way than the meshes of the model, or is a mirror image of them", said[0])
        self.assertIn("warning: " + said[0].replace("the model,", "model.h5,"), program)
        (said_of_size,) = self.warnings_of(lambda: self.model.scores(large))
        self.assertIn("times larger than the meshes of the model; are they in ", said_of_size)
        self.assertIn("warning: " + said_of_size.replace("the model;", "model.h5;"), program)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # of the collection itself
            odd = ls.collection([sound, mirror, large])
        self.assertEqual(self.warnings_of(lambda: self.model.scores(odd)), [said[0], said_of_size])
        self.assertEqual(self.warnings_of(lambda: self.model.scores(sound)), [])
        self.assertEqual(self.warnings_of(lambda: self.model.scores(self.faces)), [])
        self.assertIn("V bends the other way than the meshes of the model", self.warnings_of(lambda: self.model.scores(mirror.V))[0])

    def warnings_of_program(self, *arguments: str) -> List[str]:
        said = subprocess.run(
            [PROGRAM, *arguments, "--force"], cwd=self.folder, stderr=subprocess.PIPE, text=True
        ).stderr
        mark = "shape: warning: "
        return [line[len(mark):].replace("--", "") for line in said.split("\n") if line.startswith(mark)]

    def test_groups_that_may_mislead_are_warned_of_as_by_the_program(self) -> None:
        subjects = [f"s{i // 2}" for i in range(12)]
        plain = ["a"] * 6 + ["b"] * 6
        slip = plain[:5] + ["b", "a"] + plain[7:]
        single = ls.collection(list(self.faces), labels={"subject": subjects, "g": plain[:5] + ["b"] + plain[6:]})
        self.assertRaisesRegex(
            ls.InvalidInput, "1 block has members of several groups \\('s2'\\)",
            lambda: ls.groups(single, "g", within="subject"))
        for values, within in ((plain, ""), (slip, "subject"), (plain, "subject")):
            made = ls.collection(list(self.faces), labels={"subject": subjects, "g": values})
            made.write(self.folder / "g.h5")
            wanted = self.warnings_of_program(
                "groups", "g.h5", "--by", "g", "-o", "g.csv", *(["--within", within] if within else [])
            )
            self.assertEqual(len(wanted), 0 if values is plain and within else 1)
            said = self.warnings_of(lambda: ls.groups(made, "g", within=within, permutations=99))
            self.assertEqual(said, wanted)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            slipped = ls.groups(
                ls.collection(list(self.faces), labels={"subject": subjects, "g": slip}), "g", within="subject"
            )
        self.assertEqual((slipped.design, slipped.left_out, slipped.pairs[0].design), ("crossed", 8, "crossed"))
        nested = ls.groups(made, "g", within="subject", permutations=99)
        self.assertEqual((nested.design, nested.left_out, nested.pairs[0].design), ("nested", 0, "nested"))
        self.assertAlmostEqual(nested.overall.smallest_p, 1 / 10)  # 6! / 3!^2 / 2
        self.assertEqual(
            self.warnings_of(lambda: ls.groups(made, "g", within="subject", permutations=9, replicates=1)),
            [text.replace("bootstrap: ", "replicates: ", 1) for text in self.warnings_of_program(
                "groups", "g.h5", "--by", "g", "--within", "subject", "--bootstrap", "1", "-o", "g.csv")],
        )

    def test_differences_of_repeated_meshes_are_warned_of_as_by_the_program(self) -> None:
        made = ls.collection(
            list(self.faces),
            labels={"subject": ["p"] * 5 + ["q"] + ["r"] * 3 + ["s"] * 3, "g": ["a"] * 6 + ["b"] * 6},
        )
        made.write(self.folder / "g.h5")
        wanted = self.warnings_of_program("difference", "g.h5", "--from", "g=a", "--to", "g=b", "-o", "d.h5")
        self.assertEqual(len(wanted), 1)
        self.assertIn("those with more meshes weigh more", wanted[0])
        self.assertEqual(self.warnings_of(lambda: ls.difference(made, "g=a", "g=b")), wanted)

    def test_names_that_tables_cannot_tell_apart_are_warned_of(self) -> None:
        (said,) = self.warnings_of(lambda: ls.collection(list(self.faces)[:2], names=["x", "x.ply"]))
        self.assertIn("the names of 'x' and 'x.ply' differ by outer blanks, endings", said)

    def test_what_was_not_tested_is_nan(self) -> None:
        made = ls.collection(list(self.faces), labels={"g": ["a", "b"] + ["c"] * 10})
        pair = ls.groups(made, "g", permutations=9).pairs[0]
        for figure in (pair.adjusted_p, pair.test.p_value, pair.test.f, pair.test.r_squared):
            self.assertTrue(np.isnan(figure))
        self.assertEqual(repr(pair.test), "Test(too few meshes for a test)")

    def test_meshes_unlike_those_of_a_difference_are_named_as_by_the_program(self) -> None:
        sound = self.faces[0]
        mirror = ls.Mesh(sound.V * [-1, 1, 1], sound.F, "mirror")
        large = ls.Mesh(1000 * sound.V, sound.F, "large")
        values = sorted({str(value) for value in self.faces.labels["expression"]})
        unit, none = (
            ls.difference(
                self.faces, f"expression={values[0]}", f"expression={values[1]}", scale=scale
            )
            for scale in ("unit", "none")
        )
        (said,) = self.warnings_of(lambda: unit.apply(mirror, quality="preview"))
        self.assertRegex(said, "^onto: mirror bends the other way than the meshes of the difference, or is a mirror image ")
        self.assertEqual(self.warnings_of(lambda: unit.apply(large, quality="preview")), [])
        (said,) = self.warnings_of(lambda: none.apply(large, quality="preview"))
        self.assertRegex(said, "^onto: large is .* times larger than the meshes of the difference; ")
        self.assertEqual(self.warnings_of(lambda: none.apply(sound, quality="preview")), [])
        self.assertEqual(self.warnings_of(lambda: none.apply(quality="preview")), [])

    def test_formats_keep_what_they_can(self) -> None:
        mesh = self.faces[0]
        heat = np.linspace(0, 1, len(mesh.V))
        for ending in (".ply", ".vtk", ".vtp"):
            path = self.folder / f"hot{ending}"
            mesh.write(path, scalars={"heat": heat}, ascii=True)
            np.testing.assert_array_equal(ls.read_mesh(path).V, mesh.V)
            self.assertIn("heat", path.read_text())
        mesh.write(self.folder / "m.stl")
        with warnings.catch_warnings(record=True):
            read = ls.read(self.folder / "m.stl")
        self.assertIn("single precision", " ".join(read.notes))
        self.assertIn("first appearance", " ".join(read.notes))
        with self.assertRaisesRegex(ls.InvalidInput, "values at vertices"):
            mesh.write(self.folder / "m.obj", scalars={"heat": heat})

    def test_tables(self) -> None:
        try:
            import pandas
        except ImportError:
            self.skipTest("no pandas")
        scores = self.model.scores(self.faces).table()
        self.assertEqual(tuple(scores["mesh"]), self.faces.names)
        self.assertEqual(ls.distance(self.faces).table().shape, (12, 12))
        self.assertEqual(len(ls.groups(self.faces, "expression", permutations=9).table()), 4)
        self.assertEqual(len(self.faces.table()), 12)

    def test_every_mesh_has_a_name(self) -> None:
        with self.assertRaisesRegex(ls.InvalidInput, r"names\[1\]: is empty"):
            ls.collection([self.faces[0], self.faces[1]], names=["a", ""])

    def test_labels_named_like_columns(self) -> None:
        for name in ("size", "residual", "pc1"):
            sized = ls.collection([self.faces[0], self.faces[1]], labels={name: ["a", "b"]})
            with self.assertRaisesRegex(ls.InvalidInput, f"label '{name}' has the name"):
                self.model.scores(sized).as_dict()

    def test_explorer(self) -> None:
        try:
            self.model.explorer(self.folder / "page.html", title="A page")
        except ValueError as error:
            self.assertIn("built without the page", str(error))
            self.skipTest("the program is built without the page")
        self.assertIn("A page", (self.folder / "page.html").read_text(encoding="utf-8"))

    def test_every_public_name_is_documented(self) -> None:
        for name in ls.__all__:
            thing = getattr(ls, name)
            if name in ("Array", "Indices", "MeshLike", "Progress"):
                continue
            self.assertTrue(thing.__doc__, name)
            for member, value in vars(thing).items() if isinstance(thing, type) else ():
                if not member.startswith("_") and (callable(value) or isinstance(value, property)):
                    self.assertTrue(value.__doc__, f"{name}.{member}")


if __name__ == "__main__":
    unittest.main(verbosity=1)
