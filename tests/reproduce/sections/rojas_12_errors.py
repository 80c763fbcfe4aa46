# SPDX-License-Identifier: MIT
"""Rojas 2014, Fig. 12; drawn for docs/interpolation.md."""

TITLE = "Errors along the bending arm (Rojas 2014, Fig. 12)"


def make(experiment):
    del experiment
    return """Edge RMS and worst edge of 100 frames between a bent arm and a straight one, for all three methods:
[interpolation.md](interpolation.md#rojas-et-al-figure-12), which has the figures. The paper measures 0.75 % and 15 % for its own
method (`closure`), 0.5 % and 40 % for Winkler's (`multiscale`).
"""
