#!/usr/bin/python3
# SPDX-License-Identifier: MIT
"""PYTHONPATH=build/release/tools/python tests/benchmarks/python_calls.py

What a call of the Python package costs beside its work [us]: the median of many, of calls whose work is next to
nothing; and how long Ctrl-C takes (tests/python/package_test.py prints that).
"""
import statistics
import time

import numpy as np

import libshape as ls
from libshape import _core

mesh = ls.synthetic("arm", vertices=200)[0]
model = ls.synthetic("arm", vertices=200).model()
V, F = mesh
handed_over = np.zeros(1)


def median_us(run, count=3000):
    times = []
    for _ in range(count):
        start = time.perf_counter()
        run()
        times.append(time.perf_counter() - start)
    return 1e6 * statistics.median(times)


print(f"a view (model.variances):                     {median_us(lambda: model.variances):6.1f} us")
print(f"a Mesh of arrays that fit:                    {median_us(lambda: ls.Mesh(V, F)):6.1f} us")
print(f"work in a thread of its own that does nothing:{median_us(lambda: _core.wait(0.0, 1.0, None)):6.1f} us")
print(f"model.scores(V) of 200 vertices, work and all:{median_us(lambda: model.scores(V)):6.1f} us")
