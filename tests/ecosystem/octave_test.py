# SPDX-License-Identifier: MIT
"""Octave loads collections and models whole."""
import shutil
import tempfile
from pathlib import Path

from ecosystem import command, shape, skip

if shutil.which("octave-cli") is None:
    skip("Ecosystem.Octave", "octave-cli is not there (octave)")
with tempfile.TemporaryDirectory() as name:
    folder = Path(name)
    shape(folder, "synth", "faces", "-o", "faces", "--count", "3", "--vertices", "400")
    shape(folder, "collect", "faces", "--labels", "faces/labels.csv", "--store-derived", "-o", "faces.h5")
    shape(folder, "stats", "faces.h5", "-o", "model.h5", "--modes", "4")
    shape(folder, "export", "model.h5", "--to", "statismo", "-o", "statismo.h5")
    (folder / "whole.m").write_text(
        """
c = load("faces.h5");
assert(ndims(c.points) == 3 && size(c.points, 1) == 3 && size(c.points, 3) == 9)
assert(isfield(c, "labels") && isfield(c.labels, "expression") && isfield(c, "names"))
assert(size(c.topology.faces, 1) == 3)
v = c.points(:, :, 2); e = double(c.topology.edges) + 1; % Octave turns the order of extents round
d = v(:, e(1, :)) - v(:, e(2, :));
assert(max(abs(sqrt(sum(d .^ 2))' - c.edge_lengths(:, 2))) < 1e-9)
m = load("model.h5");
assert(numel(m.variances) == 4 && size(m.modes.edge_lengths, 2) == 4)
s = load("statismo.h5");
assert(s.version.minorVersion == 9 && size(s.model.pcaBasis, 1) == numel(s.model.pcaVariance))
printf("loaded: %s\\n", strjoin(fieldnames(c)', ", "));
""",
        encoding="utf-8",
    )
    print(*command(folder, "octave-cli", "--norc", "--quiet", "whole.m"), sep="\n")
