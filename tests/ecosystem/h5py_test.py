# SPDX-License-Identifier: MIT
"""h5py and pandas read collections and tables."""
import tempfile
from pathlib import Path

from ecosystem import needs, shape

h5py, np = needs("Ecosystem.H5py", "h5py", "numpy")
with tempfile.TemporaryDirectory() as name:
    folder = Path(name)
    shape(folder, "synth", "faces", "-o", "faces", "--count", "3", "--vertices", "400")
    labels = (folder / "faces/labels.csv").read_text(encoding="utf-8").replace(",happy", ",fröhlich")
    (folder / "labels.csv").write_text(labels, encoding="utf-8")
    shape(folder, "collect", "faces", "--labels", "labels.csv", "--store-derived", "-o", "faces.h5")
    with h5py.File(folder / "faces.h5") as f:
        points, names = f["points"][...], f["names"].asstr()[...]
        edges, lengths = f["topology/edges"][...], f["edge_lengths"][...]
        expressions = f["labels/expression"].asstr()[...]
        assert f["names"].id.get_type().get_cset() == h5py.h5t.CSET_ASCII
        assert f["labels/expression"].id.get_type().get_cset() == h5py.h5t.CSET_UTF8
    assert set(expressions) == {"neutral", "fröhlich", "angry"} and len(names) == 9
    ends = points[:, edges]
    assert np.allclose(np.linalg.norm(ends[:, :, 0] - ends[:, :, 1], axis=2), lengths, rtol=1e-12)
    shape(folder, "info", "faces.h5")
