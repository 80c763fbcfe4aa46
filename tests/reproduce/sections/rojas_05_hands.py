# SPDX-License-Identifier: MIT
"""Rojas 2014, Fig. 5: hands along a spline; drawn for docs/interpolation.md."""

TITLE = "Hands along a spline (Rojas 2014, Fig. 5)"


def make(experiment):
    del experiment
    return """Three poses of a real hand of 6,355 vertices (`point`, `victory`, `fist_5`) and the way between on a Catmull-Rom spline; the
paper's hand has 10,000 vertices. Errors are in [interpolation.md](interpolation.md#four-arms-as-a-patch-three-hands-along-a-spline).

![hands along a spline](images/hand.png)
"""
