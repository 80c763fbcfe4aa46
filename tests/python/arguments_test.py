# SPDX-License-Identifier: MIT
"""What the Python package takes and refuses, and what it never does to what is there."""
import copy
import csv
import errno
import os
import tempfile
import unittest
import warnings
from pathlib import Path
from types import SimpleNamespace

import numpy as np

import libshape as ls
from ecosystem import shape

try:
    import pandas
except ImportError:
    pandas = None

faces = ls.synthetic("faces", count=4, vertices=400)
model = faces.model(modes=5)
V, F = faces[0]
MISSING = [None, float("nan"), "", "NA", "n/a", "<NA>", "NaN", "NULL", ".", " na "]


class Refusals(unittest.TestCase):
    def refused(self, kind: type, cases: dict) -> None:
        for words, run in cases.items():
            with self.subTest(words), self.assertRaisesRegex(kind, words) as caught:
                run()
            if not hasattr(caught, "exception"):
                continue  # the subtest has failed
            self.assertNotRegex(str(caught.exception), r"--|Options|incompatible function arguments|/tmp")

    def test_types_are_named_with_what_came(self) -> None:
        self.refused(TypeError, {
            "meshes: must be a Collection, is list": lambda: ls.groups([faces[0]], "expression"),
            "meshes: must be a Collection, is NoneType": lambda: ls.distance(None),
            "meshes: must be a Collection, is Mesh": lambda: ls.difference(faces[0], "a=b", "a=c"),
            "by: must be a str, is int 3": lambda: ls.groups(faces, 3),
            "within: must be a str, is NoneType": lambda: ls.groups(faces, "expression", within=None),
            "permutations: must be a whole number, is float 9.5":
                lambda: ls.groups(faces, "expression", permutations=9.5),
            "permutations: must be a whole number, is bool True":
                lambda: ls.groups(faces, "expression", permutations=True),
            "seed: must be a whole number, is str 'x'": lambda: ls.groups(faces, "expression", seed="x"),
            "metric: must be a str": lambda: ls.distance(faces, 3),
            "modes: must be a whole number, is str '5'": lambda: faces.model(modes="5"),
            "variance: must be a number, is str": lambda: faces.model(variance="0.9"),
            "space: must be a str, is int": lambda: faces.model(space=3),
            "area_weighted: must be True or False, is str": lambda: faces.model(area_weighted="yes"),
            "with_positions: must be a number, is str": lambda: faces.model(with_positions="5"),
            "scores: must be an array of numbers, is str": lambda: model.decode("abc"),
            r"scores: shape must be \(k,\), is \(\)": lambda: model.decode(3),
            "size: must be a number, is str": lambda: model.decode([1], size="big"),
            "method: must be a str, is NoneType": lambda: model.decode([1], method=None),
            "smoothness: must be a number": lambda: model.decode([1], smoothness=[1]),
            "seed: must be a whole number, is float 1.0": lambda: model.decode([1], seed=1.0),
            "n: must be a whole number, is float": lambda: model.sample(2.0),
            "mode: must be a whole number, is str": lambda: model.feasible_range("0"),
            "V: must be an array of numbers, is NoneType": lambda: model.scores(None),
            "path: must be a str or a path, is int 3": lambda: model.write(3),
            "path: must be a str or a path, is bytes": lambda: faces.write(b"c.h5"),
            "path: must be a str or a path, is NoneType": lambda: ls.read_model(None),
            "paths: must be a path or a list of paths, is int": lambda: ls.read(3),
            r"paths\[1\]: must be a str or a path, is int": lambda: ls.read(["a.ply", 4]),
            "triangulate: must be True or False, is int 1": lambda: ls.read("a.ply", triangulate=1),
            "untrusted: must be True or False": lambda: ls.read_model("m.h5", untrusted="yes"),
            "labels: must map names to values": lambda: ls.read("a.ply", labels=3),
            "labels: must map names to values .*, is list": lambda: ls.collection([(V, F)], labels=["a"]),
            r"labels\['g'\]: must be a sequence of values, is str":
                lambda: ls.collection([(V, F), (V, F)], labels={"g": "ab"}),
            r"labels\['g'\]: 1 values for 2 meshes":
                lambda: ls.collection([(V, F), (V, F)], labels={"g": ["a"]}),
            r"names\[0\]: must be a str, is int": lambda: ls.collection([(V, F)], names=[3]),
            "names: must be a list of str, is str": lambda: ls.collection([(V, F)], names="a"),
            "meshes: must be a list of meshes, is int": lambda: ls.collection(3),
            r"meshes\[0\]: must be a Mesh or a pair \(V, F\), is int": lambda: ls.collection([3]),
            "amount: must be a number, is str": lambda: smile().apply(V, "much"),
            "onto: must be a Mesh or a pair": lambda: smile().apply(3),
            "pair_by: must be a str, is NoneType":
                lambda: ls.difference(faces, "expression=neutral", "expression=happy", pair_by=None),
            "from_: must be 'LABEL=VALUE', is str 'neutral'": lambda: ls.difference(faces, "neutral", "a=b"),
            "to: must be 'LABEL=VALUE', is int 3": lambda: ls.difference(faces, "a=b", 3),
            r"landmarks\['nose'\]: must be \(on the template, on the scan\), is int":
                lambda: ls.fit((V, F), (V, F), {"nose": 3}),
            "landmarks: must map names to values": lambda: ls.fit((V, F), (V, F), [3]),
            "boundaries: must be a list of str, is str": lambda: ls.fit((V, F), (V, F), boundaries="mouth"),
            "search: must be True or False": lambda: ls.fit((V, F), (V, F), search="no"),
            "meshes: give two or more, one by one .* there is one, list":
                lambda: ls.interpolate([faces[0], faces[1]], frames=3),
            "meshes: give two or more, .* there is none": lambda: ls.interpolate(frames=3),
            "frames: must be a whole number, is str": lambda: ls.interpolate(faces[0], faces[1], frames="3"),
            "squared: must be True or False": lambda: ls.interpolate(faces[0], faces[1], frames=3, squared=2),
            "name: must be a str, is int": lambda: ls.synthetic(3),
            "count: must be a whole number": lambda: ls.set_thread_count("2"),
            "quality: must be a str": lambda: faces[0].write("x.ply", quality=3),
            "ascii: must be True or False": lambda: faces[0].write("x.ply", ascii="yes"),
            "template: must be a str or a path": lambda: faces[0].write("x.obj", template=3),
            "scalars: must map names to values": lambda: faces[0].write("x.ply", scalars=[1]),
            "force: must be True or False": lambda: model.export("x", "csv", force="yes"),
            "title: must be a str": lambda: model.explorer("x.html", title=3),
            "color_by: must be a str": lambda: model.explorer("x.html", color_by=3),
            "progress: must be None, True or a function, is int 3":
                lambda: model.export("x", "csv", progress=3),
            r"c\[...\]: must be a number, a name, .*, is bool True": lambda: faces[True],
            r"c\[...\]: must be a number, a name, .*, is float 1.5": lambda: faces[1.5],
            r"c\[...\]: .*, is NoneType": lambda: faces[None],
            r"c\[...\]: .*, has an item that is float": lambda: faces[[0, 1.5]],
            "in: must be the name of a mesh, is Mesh": lambda: faces[0] in faces,
            r"frames\[...\]: must be a whole number, is str":
                lambda: ls.interpolate(faces[0], faces[1], frames=2)["a"],
        })

    def test_values_are_named_with_their_rule(self) -> None:
        hole = np.ma.masked_array(V, mask=V > V.max() - 1e-9)
        bad = V.copy()
        bad[3, 1] = np.nan
        self.refused(ls.InvalidInput, {
            "frames: is -3, must be at least 2": lambda: ls.interpolate(faces[0], faces[1], frames=-3),
            "frames: is 1, must be at least 2": lambda: ls.interpolate(faces[0], faces[1], frames=1),
            "meshes: there is 1, there must be at least 2": lambda: ls.interpolate(faces[:1], frames=3),
            "^principal components: modes is 99, must be in": lambda: faces.model(modes=99),
            "modes: is -1, must be at least 0": lambda: faces.model(modes=-1),
            "modes: is 99, must be at most 5": lambda: model.export("x", "csv", modes=99),
            "mode: is 5, must be at most 4": lambda: model.feasible_range(5),
            "n: is -1, must be at least 0": lambda: model.sample(-1),
            "seed: is -1, must be at least 0": lambda: model.sample(1, seed=-1),
            "permutations: is 1000000000000, must be at most":
                lambda: ls.groups(faces, "expression", permutations=10**12),
            "meshes: there is none": lambda: ls.collection([]),
            "paths: there is none": lambda: ls.read([]),
            r"c\[...\]: chooses none of the 12 meshes": lambda: faces[3:3],
            r"c\[...\]: chooses none": lambda: faces[[]],
            r"c\[...\]: chooses mesh 's000_neutral' twice": lambda: faces[[0, -12]],
            r"c\[...\]: 2 of True and False for 12 meshes": lambda: faces[[True, False]],
            "V: is a masked array in which 1 are masked": lambda: model.scores(hole),
            "mesh.V: is a masked array": lambda: ls.edges((hole, F)),
            "mesh.V: has a coordinate that is not finite": lambda: ls.edges((bad, F)),
            "V: vertex 3 .*nan|V has a coordinate that is not finite": lambda: model.scores(bad),
            "V: face .* has no area|V: .*area": lambda: model.scores(np.zeros_like(V)),
            r"scores\[1\]: is nan, must be finite": lambda: model.decode([1.0, np.nan]),
            r"scores\[0, 1\]: is inf, must be finite": lambda: model.decode_all([[1.0, np.inf]]),
            "size: is nan, must be finite": lambda: model.decode([1], size=np.nan),
            "smoothness: is nan, must be finite": lambda: model.decode([1], smoothness=np.nan),
            "seed: is -5, must be at least 0": lambda: ls.interpolate(faces[0], faces[1], frames=2, seed=-5),
            "seed: is 18446744073709551616, must be at most": lambda: smile().apply(seed=2**64),
            r"weights\[0, 0\]: is nan": lambda: ls.interpolate(faces[0], faces[1], weights=[[np.nan, 1]]),
            "amount: is nan, must be finite": lambda: smile().apply(faces[0], np.nan),
            r"onto.V\[3, 1\]: is nan": lambda: smile().apply((bad, F)),
            r"landmarks\['nose'\]\[2\]: is nan":
                lambda: ls.fit((V, F), (V, F), {"nose": (0, [0, 0, np.nan])}),
            "path: 'x.h5' is a file; all but to statismo write a folder": lambda: model.export("x.h5", "csv"),
            "to: 'blender' must be one of statismo": lambda: model.export("x", "blender"),
            "path: '' names no file": lambda: ls.read_model(""),
            "from_: 'expression=NA' names no value":
                lambda: ls.difference(faces, "expression=NA", "expression=happy"),
            "labels: 'g ' occurs twice":
                lambda: ls.collection([(V, F)], labels={"g": ["a"], "g ": ["b"]}),
            "labels: '' must name a label": lambda: ls.collection([(V, F)], labels={"": ["a"]}),
            "F: row 0 names vertex": lambda: ls.edges((V, F - 10**6)),
        })

    def test_messages_of_the_library_name_the_arguments(self) -> None:
        """Where its fields are called otherwise, and a few where they are not."""
        neutral, happy = "expression=neutral", "expression=happy"
        frames = ls.interpolate(faces[0], faces[1], frames=2)
        self.refused(ls.InvalidInput, {
            r"^with_dihedrals is -1, must be in \[0, 1e6\]$": lambda: faces.model(with_dihedrals=-1),
            r"^with_positions is -2, must be in \[0, 1e6\]$": lambda: ls.groups(faces, "expression", with_positions=-2),
            "^with_dihedrals is set, but belongs to edge space":
                lambda: faces.model(space="procrustes", with_dihedrals=1),
            "^with_positions is set": lambda: faces.model(space="procrustes", with_positions=1),
            "^area_weighted is set": lambda: faces.model(space="procrustes", area_weighted=True),
            "^coordinates is set": lambda: faces.model(space="procrustes", coordinates="log"),
            "^to is happy, must be another group": lambda: ls.difference(faces, happy, happy),
            "^from_ is empty, must be a label": lambda: ls.difference(faces, " =neutral", happy),
            "^to is empty, must be a label": lambda: ls.difference(faces, neutral, " =happy"),
            "^variance is 2, must be in": lambda: faces.model(variance=2),
            "^variance is 0.5, must be 1 where modes": lambda: faces.model(modes=2, variance=0.5),
            "^quality is set, but belongs to the method 'dihedral', which":
                lambda: model.decode([1], method="closure", quality="fine"),
            "^smoothness is set, but belongs to the method 'dihedral'":
                lambda: smile().apply(method="multiscale", smoothness=1),
            "^smoothness is 0, must be > 0": lambda: ls.interpolate(faces[0], faces[1], frames=2, smoothness=0),
            "^smoothness is -1, must be > 0": lambda: ls.fit(faces[0], faces[0], smoothness=-1),
            "^growth_smoothness is 0, must be > 0": lambda: ls.fit(faces[0], faces[0], growth_smoothness=0),
            "^landmark_tolerance is -1, must be >= 0": lambda: ls.fit(faces[0], faces[0], landmark_tolerance=-1),
            "^frames_per_second is 0, must be > 0": lambda: frames.write("x.glb", frames_per_second=0),
            "^frames_per_second is 1e.07, must be in": lambda: frames.write("x.glb", frames_per_second=1e7),
            "^tolerance is -1, must be >= 0": lambda: frames.write("x.glb", tolerance=-1),
            "^colors: has 1 rows, the mesh has": lambda: faces[0].write("x.ply", colors=np.zeros((1, 3), np.uint8)),
        })

    def test_endings_that_do_not_fit_what_is_written(self) -> None:
        frames = ls.interpolate(faces[0], faces[1], frames=2)
        with tempfile.TemporaryDirectory() as folder:
            for ending, write in (
                (".glb", frames.write),
                (".h5", faces.write),
                (".h5", model.write),
                (".h5", smile().write),
                (".h5", lambda path: model.export(path, "statismo")),
                (".html", model.explorer),
            ):
                for name in ("x.ply", "x.txt", "x", "x.h5.gz"):
                    with self.assertRaisesRegex(ls.InvalidInput, f"path: '.*{name}' must end in {ending}"):
                        write(os.path.join(folder, name))
            with self.assertRaisesRegex(ls.InvalidInput, "ending"):
                faces[0].write(os.path.join(folder, "x.docx"))
            self.assertEqual(os.listdir(folder), [])


def smile() -> ls.Difference:
    return ls.difference(faces, "expression=neutral", "expression=happy", pair_by="subject")


class Outputs(unittest.TestCase):
    def setUp(self) -> None:
        scratch = tempfile.TemporaryDirectory()
        self.addCleanup(scratch.cleanup)
        self.folder = Path(scratch.name)

    def test_nothing_is_replaced_by_surprise(self) -> None:
        """One rule: write() replaces its file; what makes folders or pages asks for force."""
        mine = self.folder / "thesis"
        mine.mkdir()
        (mine / "chapter.txt").write_text("years of work")
        page = self.folder / "page.html"
        page.write_text("mine")
        statismo = self.folder / "x.h5"
        statismo.write_text("mine")
        for write in (
            lambda: model.export(mine, "csv"),
            lambda: model.export(f"{mine}/", "shapeworks"),
            lambda: model.export(statismo, "statismo"),
            lambda: model.explorer(page),
        ):
            with self.assertRaisesRegex(FileExistsError, "exists.* force=True ") as caught:
                write()
            self.assertIsInstance(caught.exception, ls.FileError)
        self.assertEqual((mine / "chapter.txt").read_text(), "years of work")
        self.assertEqual((page.read_text(), statismo.read_text()), ("mine", "mine"))
        model.export(statismo, "statismo", force=True)
        model.export(mine, "csv", force=True)
        self.assertEqual((mine / "chapter.txt").read_text(), "years of work")
        self.assertTrue((mine / "landmarks.csv").exists())
        self.assertTrue(statismo.read_bytes().startswith(b"\x89HDF"))
        for name, write in (
            ("m.ply", faces[0].write),
            ("c.h5", faces.write),
            ("m.h5", model.write),
            ("d.h5", smile().write),
            ("f.glb", ls.interpolate(faces[0], faces[1], frames=2).write),
        ):
            write(self.folder / name)
            before = (self.folder / name).read_bytes()
            write(self.folder / name)
            self.assertEqual((self.folder / name).read_bytes(), before)

    def test_a_model_is_exported_as_it_is_in_memory(self) -> None:
        path = self.folder / "model.h5"
        model.write(path)
        read = ls.read_model(path)
        faces.model(modes=1, space="procrustes").write(path)
        read.export(self.folder / "after", "csv")
        model.export(self.folder / "wanted", "csv")
        for name in sorted(os.listdir(self.folder / "wanted")):
            self.assertEqual(
                (self.folder / "after" / name).read_bytes(), (self.folder / "wanted" / name).read_bytes()
            )
        path.unlink()
        read.export(self.folder / "gone", "csv", modes=2)
        try:
            read.explorer(self.folder / "page.html", title="--a title")
        except ls.InvalidInput as error:
            self.assertIn("built without the page", str(error))
            return
        page = (self.folder / "page.html").read_text(encoding="utf-8")
        self.assertIn("--a title", page)
        self.assertIn('"file":"model.h5"', page)
        self.assertNotIn(tempfile.gettempdir() + "/libshape-", page)
        self.assertEqual((self.folder / "page.html").stat().st_mode & 0o777, path_mode(self.folder))

    def test_progress_of_exports_is_told(self) -> None:
        calls = []
        model.export(self.folder / "x", "csv", progress=lambda *told: calls.append(told))
        self.assertTrue(calls)
        self.assertEqual(calls[-1][1], calls[-1][2])
        with self.assertRaisesRegex(ZeroDivisionError, "enough"):
            def fail(*_: object) -> None:
                raise ZeroDivisionError("enough")
            model.export(self.folder / "y", "csv", progress=fail)

    def test_errors_of_files_are_those_of_python(self) -> None:
        for run, kind, number in (
            (lambda: ls.read_model(self.folder / "none.h5"), FileNotFoundError, errno.ENOENT),
            (lambda: ls.read(self.folder / "none.ply"), FileNotFoundError, errno.ENOENT),
            (lambda: ls.read_mesh(self.folder / "none.ply"), FileNotFoundError, errno.ENOENT),
            (lambda: ls.fit((V, F), self.folder / "none.ply"), FileNotFoundError, errno.ENOENT),
            (lambda: ls.read(self.folder / "c.h5"), FileNotFoundError, errno.ENOENT),
            (lambda: faces[0].write(self.folder / "none/x.ply"), FileNotFoundError, errno.ENOENT),
            (lambda: model.write(self.folder / "none/x.h5"), FileNotFoundError, errno.ENOENT),
            (lambda: model.export(self.folder / "none/x", "csv"), FileNotFoundError, errno.ENOENT),
            (lambda: model.explorer(self.folder / "none/x.html"), FileNotFoundError, errno.ENOENT),
        ):
            with self.assertRaises(kind) as caught:
                run()
            error = caught.exception
            self.assertIsInstance(error, ls.FileError)
            self.assertIsInstance(error, ls.Error)
            self.assertEqual(error.errno, number)
            self.assertEqual(error.strerror, os.strerror(number))
            self.assertTrue(error.filename.startswith(str(self.folder)), error.filename)
            self.assertIn(error.filename, str(error))
            again = copy.copy(error)
            self.assertEqual((type(again), str(again)), (type(error), str(error)))


def path_mode(folder: Path) -> int:
    """The mode of a file that is simply written."""
    (folder / "plain").write_text("")
    return (folder / "plain").stat().st_mode & 0o777


class Labels(unittest.TestCase):
    def test_what_is_missing_is_in_no_group(self) -> None:
        count = len(MISSING)
        meshes = [m.V * (1 + 0.01 * i) for i, m in enumerate(faces)][:count]
        some = ["a", "b"] * count
        for word in MISSING:
            labels = {"g": [word, *some[: count - 1]]}
            made = ls.collection(meshes, F, labels=labels)
            self.assertIsNone(made.labels["g"][0])
            with self.assertRaisesRegex(ls.InvalidInput, "mesh mesh_0000 has no value of label 'g'.*c.labels"):
                ls.groups(made, "g", permutations=9)
            with self.assertRaisesRegex(ls.InvalidInput, "mesh mesh_0000 has no value of label 'g'"):
                ls.groups(ls.collection(meshes, F, labels={**labels, "h": some[:count]}), "h", within="g")
        made = ls.collection(meshes, F, labels={"g": MISSING})
        self.assertEqual(made.labels, {"g": (None,) * count})
        # The remedy that the message names.
        c = ls.collection(meshes, F, labels={"g": [None, *some[: count - 1]]})
        rest = c[[v is not None for v in c.labels["g"]]]
        self.assertEqual(ls.groups(rest, "g", permutations=9).counts, (5, 4))
        self.assertEqual(c.model(modes=1).labels["g"][:2], (None, "a"))
        self.assertEqual(c.model().scores(c).labels["g"][0], None)

    def test_the_same_rules_as_of_tables(self) -> None:
        values = [" happy ", "cafe\u0301", *MISSING]
        with tempfile.TemporaryDirectory() as folder:
            path = Path(folder) / "labels.csv"
            with open(path, "w", encoding="utf-8", newline="") as file:
                rows = csv.writer(file)
                rows.writerow(["mesh", "g"])
                rows.writerows([name, "" if v is None else v] for name, v in zip(faces.names, values))
            wanted = ls.collection(faces, labels=path)
            faces.write(Path(folder) / "c.h5")
            read = ls.read(Path(folder) / "c.h5", labels=path)
            shape(Path(folder), "collect", "c.h5", "--labels", "labels.csv", "-o", "of_program.h5")
            of_program = ls.read(Path(folder) / "of_program.h5")
        made = ls.collection(faces, labels={"g": values})
        self.assertEqual(made.labels, {"g": ("happy", "caf\u00e9", *[None] * len(MISSING))})
        for other in (wanted, read, of_program):
            self.assertEqual(made.labels, other.labels)
        self.assertEqual(ls.collection(faces, labels=made.labels).labels, made.labels)

    def test_rows_that_say_which_mesh_they_are_of(self) -> None:
        turned = {"mesh": [f"{name}.ply" for name in faces.names[::-1]], "n": list(range(12))[::-1]}
        self.assertEqual(
            ls.collection(faces, labels=turned).labels["n"], tuple(str(i) for i in range(12))
        )
        with self.assertRaisesRegex(ls.InvalidInput, "^labels: .*s000_neutral"):
            ls.collection(faces, labels={"mesh": faces.names[1:], "n": range(11)})
        more = ls.collection(faces, labels={"mesh": [*faces.names, "other"], "n": range(13)})
        self.assertIn("other", " ".join(more.notes))

    @unittest.skipIf(pandas is None, "no pandas")
    def test_tables_of_pandas(self) -> None:
        table = pandas.DataFrame({"age": range(12), "g": ["a", None] * 6})
        wanted = {"age": tuple(str(i) for i in range(12)), "g": ("a", None) * 6}
        named = table.set_axis(list(faces.names), axis=0)[::-1]
        column = table.assign(mesh=faces.names)[::-1]
        index = column.set_index("mesh")
        with tempfile.TemporaryDirectory() as folder:
            faces.write(Path(folder) / "c.h5")
            for given in (named, column, index):
                self.assertEqual(ls.collection(faces, labels=given).labels, wanted)
                self.assertEqual(ls.read(Path(folder) / "c.h5", labels=given).labels, wanted)
            with self.assertRaisesRegex(TypeError, "labels: must say which mesh each row is of"):
                ls.read(Path(folder) / "c.h5", labels=table)
            made = ls.collection(faces, labels=table)
            self.assertEqual(made.labels, wanted)
            faces[0].write(Path(folder) / "hot.ply", scalars=pandas.DataFrame({"heat": V[:, 0]}))
            self.assertIn(b"heat", (Path(folder) / "hot.ply").read_bytes())
        for found in (made.table(), made.model().scores(made).table()):
            self.assertEqual(list(found["g"].isna()), [False, True] * 6)
        self.assertEqual(ls.collection(faces, labels=made.table()).labels, wanted)

    @unittest.skipIf(pandas is None, "no pandas")
    def test_tables_of_groups_are_those_of_the_program(self) -> None:
        with tempfile.TemporaryDirectory() as folder:
            faces.write(Path(folder) / "c.h5")
            shape(Path(folder), "groups", "c.h5", "--by", "expression", "--within", "subject", "-o", "g.csv",
                  "--quiet")
            wanted = pandas.read_csv(Path(folder) / "g.csv", float_precision="round_trip")
        found = ls.groups(faces, "expression", within="subject").table()
        self.assertEqual(list(found.columns), list(wanted.columns))
        for column in wanted:
            with self.subTest(column):
                self.assertEqual(list(found[column].isna()), list(wanted[column].isna()))
                self.assertEqual(list(found[column].dropna()), list(wanted[column].dropna()))


class Objects(unittest.TestCase):
    def test_what_is_shared_cannot_be_changed(self) -> None:
        for array in (faces.F, faces[0].F, faces[0].V, model.F, model.decode([0])[0].F, smile().F):
            with self.assertRaisesRegex(ValueError, "read-only"):
                array[0] = 0
        for names in (faces.names, model.names, faces.labels["subject"], model.labels["subject"], smile().pairs):
            self.assertIsInstance(names, tuple)
        faces.labels["subject"] = ()
        model.labels.clear()
        self.assertEqual((len(faces.labels["subject"]), len(model.labels)), (12, 2))

    def test_choosing_meshes(self) -> None:
        names = [faces.names[4], faces.names[1]]
        for key in (names, [4, 1], np.array([4, 1]), np.array(names), (4, 1)):
            self.assertEqual(faces[key].names, tuple(names))
        mask = [name in names for name in faces.names]
        for key in (mask, np.array(mask)):
            self.assertEqual(faces[key].names, tuple(names[::-1]))
        self.assertEqual(faces[1:3].names, faces.names[1:3])
        self.assertIn("s000_neutral", faces)
        self.assertNotIn("nobody", faces)
        with self.assertRaises(KeyError):
            faces[["nobody"]]
        with self.assertRaises(IndexError):
            faces[[12]]
        frames = ls.interpolate(faces[0], faces[1], frames=4)
        self.assertEqual(frames[-1].name, "frame_0003")
        self.assertEqual([mesh.name for mesh in frames[1:3]], ["frame_0001", "frame_0002"])
        self.assertEqual((len(frames[1:3].reports), frames[1:3].weights.shape), (2, (2, 2)))

    def test_scores_of_any_mesh(self) -> None:
        wanted = model.scores(V).scores
        for mesh in (
            faces[0],
            (V, F),
            [V.tolist(), F.tolist()],
            V.tolist(),
            SimpleNamespace(vertices=V, faces=F),
            SimpleNamespace(points=V, cells_dict={"triangle": F}),
        ):
            np.testing.assert_array_equal(model.scores(mesh).scores, wanted)
        self.assertEqual(model.scores(faces[0]).names, ("s000_neutral",))
        for other in ((V, F[:, ::-1]), SimpleNamespace(vertices=V, faces=F[::-1])):
            with self.assertRaisesRegex(ls.InvalidInput, "meshes: face 0 is .*, in the model it is .*; "):
                model.scores(other)

    def test_results_can_be_compared_and_kept_in_sets(self) -> None:
        mesh, report = model.decode([1])
        for thing in (
            mesh, report, faces, model, smile(), model.scores(V), ls.distance(faces), ls.edges(mesh),
            ls.groups(faces, "expression", permutations=9), ls.interpolate(mesh, faces[1], frames=2),
            ls.fit(faces[0], faces[0])[1],
        ):
            self.assertEqual(thing, thing)
            self.assertNotEqual(thing, 3)
            self.assertEqual(len({thing, thing}), 1)
            self.assertEqual(repr(copy.deepcopy(thing)), repr(thing))
        self.assertEqual(
            ls.groups(faces, "expression", permutations=9), ls.groups(faces, "expression", permutations=9)
        )

    def test_what_is_odd_is_warned_of(self) -> None:
        with tempfile.TemporaryDirectory() as folder:
            for mesh in (faces[0], ls.Mesh(faces[1].V * 1000.0, F, "mesh_0001")):
                mesh.write(Path(folder) / f"{mesh.name}.ply")
            with warnings.catch_warnings(record=True) as of_read:
                warnings.simplefilter("always")
                ls.read(folder)
        with warnings.catch_warnings(record=True) as of_collection:
            warnings.simplefilter("always")
            ls.collection([faces[0], (faces[1].V * 1000.0, F)])
        self.assertTrue(of_read)
        self.assertEqual([str(w.message) for w in of_collection], [str(w.message) for w in of_read])
        with warnings.catch_warnings(record=True) as of_interpolation:
            warnings.simplefilter("always")
            made = ls.collection([faces[0], (faces[1].V * 1000.0, F)])
            of_interpolation.clear()
            ls.interpolate(made, frames=2, quality="preview")
            self.assertEqual(of_interpolation, [])  # the collection has said it
            ls.interpolate(faces[0], (faces[1].V * 1000.0, F), frames=2, quality="preview")
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            ls.interpolate(faces[0], faces[1], faces[0], frames=3, quality="preview")  # a path that comes back
        self.assertEqual([str(w.message) for w in of_interpolation],
                         [str(w.message).replace(faces.names[0], "mesh_0000") for w in of_read])
        for warned in (of_collection[0], of_interpolation[0]):
            self.assertEqual(warned.filename, __file__)
        with self.assertWarnsRegex(UserWarning, "'f' and 'F', which are two groups"):
            ls.collection(list(faces)[:2], labels={"sex": ["f", "F"]})

    def test_errors_say_what_they_are(self) -> None:
        for kind in (ls.Error, ls.InvalidInput, ls.NumericalError, ls.FileError, ls.LimitExceeded):
            self.assertTrue(kind.__doc__)
            self.assertEqual(kind.__module__, "libshape")


if __name__ == "__main__":
    warnings.simplefilter("ignore", UserWarning)
    unittest.main(verbosity=1)
