# SPDX-License-Identifier: MIT
"""Rojas 2014, Fig. 12; drawn for docs/interpolation.md."""

TITLE = "Errors along the bending arm (Rojas 2014, Fig. 12)"


def make(experiment):
    del experiment
    return """Edge RMS and worst edge of 100 frames between a bent arm and a straight one, for all three methods.

![edge RMS and worst edge of every frame](images/rojas_figure_12.png)

The paper measures at most 0.75 % and 15 % for its own method (`closure`), 0.5 % and 40 % for Winkler's (`multiscale`). On
this arm, whose elbow folds sharply, both are worse, and `dihedral` is below them at every frame:
[interpolation.md](interpolation.md#rojas-et-al-figure-12) has the figures.
"""
