# SPDX-License-Identifier: MIT
"""Rojas 2014, Fig. 11; drawn for docs/conformal.md."""

TITLE = "Conformal morph to the sphere (Rojas 2014, Fig. 11)"


def make(experiment):
    del experiment
    return """A head, closed off at the back, at k = 0, 1/4, 1/2, 3/4, 1. Figures and commands are in [conformal.md](conformal.md#the-morph); the
paper gives none. It suspects that regions switch from dents to bulges near the end; that is so, and where the
switch is made is measured there.

![the head at k = 0, 1/4, 1/2, 3/4, 1](images/conformal_head.png)
"""
