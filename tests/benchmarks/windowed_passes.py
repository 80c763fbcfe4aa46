#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Prints how near five ways of finding principal components come in some passes over the data: a table of
docs/experiments/scale.md.

windowed_passes.py

3,000 rows, 300 modes of which each has 0.93 times the variance of the one before (as planted_benchmark.cpp), 50 of
which are wanted, blocks of 60. "windows" goes as PCAone does (Li et al. 2023, Genome Research 33): the
block is multiplied anew after each window of rows, of which there are 16 in the first pass (more would have fewer
rows than the block has columns) and half as many in each one that follows. Errors are the largest of the 50
variances, relative to the exact ones: what each way could give if it stopped there. A quarter of a minute.
"""
import numpy as np

from common import row, table

ROWS, COLUMNS, MODES, WANTED, BLOCK, DECAY = 3000, 2000, 300, 50, 60, 0.93


def planted(random):
    """Centred rows with known variances."""
    scores = random.normal(size=(ROWS, MODES))
    scores = np.linalg.qr(scores - scores.mean(axis=0))[0]
    modes = np.linalg.qr(random.normal(size=(COLUMNS, MODES)))[0]
    return scores * DECAY ** (0.5 * np.arange(MODES)) @ modes.T


def error(data, basis):
    """Of the variances that the span of a basis gives."""
    basis = np.linalg.qr(basis)[0]
    found = np.linalg.svd(data @ basis, compute_uv=False)[:WANTED] ** 2
    return np.abs(found / DECAY ** np.arange(WANTED) - 1).max()


def power(data, block):
    while True:
        block = data.T @ (data @ np.linalg.qr(block)[0])
        yield error(data, block)


def windows(data, block):
    count = 16
    while True:
        half = np.zeros_like(block)
        for part in np.array_split(data, 2 * count):  # halves of windows, each used twice
            block = np.linalg.qr(block)[0]
            before, half = half, part.T @ (part @ block)
            if count > 1 or before.any():
                block = before + half
        count = max(count // 2, 1)
        yield error(data, block)


def krylov(data, block):
    basis = np.linalg.qr(block)[0]
    newest = basis
    while True:
        newest = data.T @ (data @ newest)
        for _ in range(2):
            newest = newest - basis @ (basis.T @ newest)
        newest = np.linalg.qr(newest)[0]
        basis = np.hstack([basis, newest])
        yield error(data, basis)


def main():
    random = np.random.default_rng(1)
    data = planted(random)
    start = random.normal(size=(COLUMNS, BLOCK))
    some = data[:: ROWS // 128][:128]
    leading = np.linalg.svd(some - some.mean(axis=0), full_matrices=False)[2][:BLOCK - 6].T
    sampled = np.hstack([leading, random.normal(size=(COLUMNS, 6))])
    table(["way", *[f"{k} passes" if k > 1 else "1 pass" for k in range(1, 9)]])
    for name, way, first in [("power iteration, random start", power, start), ("windows, random start", windows, start),
                             ("windows, start from 128 rows", windows, sampled),
                             ("block Krylov, random start", krylov, start),
                             ("block Krylov, start from 128 rows", krylov, sampled)]:
        steps = way(data, first)
        row(name, *[f"{next(steps):.0e}" for _ in range(8)])


if __name__ == "__main__":
    main()
