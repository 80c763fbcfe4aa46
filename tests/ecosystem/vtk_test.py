# SPDX-License-Identifier: MIT
"""VTK, and so ParaView and Slicer, reads our VTK and VTP files with their scalars, and we read every form of its
own: text, binary, appended, packed."""
import tempfile
from pathlib import Path

from ecosystem import needs, read_ascii_ply, shape

vtk, np, h5py = needs("Ecosystem.Vtk", "vtk", "numpy", "h5py")
from vtk.util.numpy_support import numpy_to_vtk, vtk_to_numpy  # noqa: E402


def read_by_vtk(path: Path):
    reader = vtk.vtkPolyDataReader() if path.suffix == ".vtk" else vtk.vtkXMLPolyDataReader()
    if path.suffix == ".vtk":
        reader.ReadAllScalarsOn()
        reader.ReadAllFieldsOn()
    reader.SetFileName(str(path))
    reader.Update()
    data = reader.GetOutput()
    faces = vtk_to_numpy(data.GetPolys().GetConnectivityArray()).reshape(-1, 3)
    scalars = data.GetPointData()
    names = [scalars.GetArrayName(i) for i in range(scalars.GetNumberOfArrays())]
    return vtk_to_numpy(data.GetPoints().GetData()), faces, names


def poly_data(V, F):
    data = vtk.vtkPolyData()
    points = vtk.vtkPoints()
    points.SetData(numpy_to_vtk(V, deep=True))
    data.SetPoints(points)
    cells = vtk.vtkCellArray()
    for face in F:
        cells.InsertNextCell(3, [int(v) for v in face])
    data.SetPolys(cells)
    heat = numpy_to_vtk(V[:, 0].copy(), deep=True)
    heat.SetName("heat")
    data.GetPointData().SetScalars(heat)
    texts = vtk.vtkStringArray()
    texts.SetName("who is it")
    for text in ("short", "", "two words", 70 * "x", "two\nlines", 20000 * "y"):  # lengths of each size
        texts.InsertNextValue(text)
    bits = vtk.vtkBitArray()
    bits.SetName("bits")
    for i in range(11):
        bits.InsertNextValue(i % 2)
    for array in (texts, bits):
        data.GetFieldData().AddArray(array)
    return data


with tempfile.TemporaryDirectory() as name:
    folder = Path(name)
    shape(folder, "synth", "helix", "-o", "helix", "--count", "1", "--vertices", "300")
    files = [str(file) for file in sorted((folder / "helix").glob("*.ply"))[:2]]
    common = ["interpolate", *files, "--frames", "2", "--quiet", "--residuals", "--colors"]
    shape(folder, *common, "-o", "ply", "--ascii")
    V, F = read_ascii_ply(folder / "ply/frame_0001.ply")
    for ending in ("vtk", "vtp"):
        for number, options in enumerate(([], ["--ascii"], ["--float"], ["--ascii", "--float"])):
            out = f"{ending}{number}"
            shape(folder, *common, "-o", out, "--format", ending, *options)
            points, faces, names = read_by_vtk(folder / out / f"frame_0001.{ending}")
            assert np.array_equal(points, V.astype(points.dtype)), (ending, options)
            assert points.dtype == ("float32" if "--float" in options else "float64")
            assert np.array_equal(faces, F)
            points, faces, names = read_by_vtk(folder / out / f"residuals/frame_0001_residuals.{ending}")
            assert {"edge_error", "dihedral_drift", "colours"} <= set(names), names
            print(f"VTK reads .{ending} {options}: {len(points)} points, arrays {names}")

    data = poly_data(V, F)
    count = 0

    def check(path: Path, exact: bool) -> None:
        global count
        shape(folder, "collect", str(path), "-o", "c.h5", "--force", "--quiet")
        with h5py.File(folder / "c.h5") as f:
            found = f["points"][0]
            assert np.array_equal(f["topology/faces"][...], F), path
        assert np.abs(found - V).max() <= (0 if exact else 1e-6 * np.ptp(V)), path
        count += 1

    writer = vtk.vtkXMLPolyDataWriter()
    writer.SetInputData(data)
    writer.SetFileName(str(folder / "x.vtp"))
    for mode in ("Ascii", "Binary", "Appended"):
        for packed in (False, True):
            for encoded in (False, True):
                for order in ("LittleEndian", "BigEndian"):
                    for head in ("UInt32", "UInt64"):
                        getattr(writer, f"SetDataModeTo{mode}")()
                        writer.SetCompressorTypeToZLib() if packed else writer.SetCompressorTypeToNone()
                        writer.SetEncodeAppendedData(encoded)
                        getattr(writer, f"SetByteOrderTo{order}")()
                        getattr(writer, f"SetHeaderTypeTo{head}")()
                        writer.Write()
                        check(folder / "x.vtp", exact=mode != "Ascii")
                        if mode == "Ascii":
                            break
    legacy = vtk.vtkPolyDataWriter()
    legacy.SetInputData(data)
    legacy.SetFileName(str(folder / "x.vtk"))
    for version in (42, 51):
        for binary in (False, True):
            legacy.SetFileVersion(version)
            legacy.SetFileTypeToBinary() if binary else legacy.SetFileTypeToASCII()
            legacy.Write()
            check(folder / "x.vtk", exact=binary)
    stripper = vtk.vtkStripper()
    stripper.SetInputData(data)
    legacy.SetInputConnection(stripper.GetOutputPort())
    legacy.Write()
    shape(folder, "check", "x.vtk", "--quiet")
    stl = vtk.vtkSTLWriter()
    stl.SetInputData(data)
    stl.SetFileName(str(folder / "x.stl"))
    for binary in (False, True):
        stl.SetFileTypeToBinary() if binary else stl.SetFileTypeToASCII()
        stl.Write()
        shape(folder, "check", "x.stl", "--quiet")
    print(f"{count} forms of VTK's own files read")
