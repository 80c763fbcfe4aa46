# SPDX-License-Identifier: MIT
"""Winkler 2010, Fig. 12 to 14 and Table 1; made for docs/interpolation.md and docs/multiscale.md."""

TITLE = "Growing parts, noise, thin triangles, times (Winkler 2010, Fig. 12, 13, 14, Table 1)"


def make(experiment):
    del experiment
    return """An arm whose hand grows to twice its size as it bends (the factor falls to 1 over four edges); a helix with noise; a cylinder of long and thin triangles, all by
`dihedral`. Figures of all methods are in [interpolation.md](interpolation.md#parts-that-grow) (growing parts) and
[there](interpolation.md#noise-and-long-and-thin-triangles) (noise, thin triangles); the paper gives none.

![growing hand](images/growing4_dihedral.png)
![noisy helix](images/noisy_helix.png)
![thin cylinder](images/thin_cylinder.png)

Table 1 stands beside ours in [multiscale.md](multiscale.md#cost).
"""
