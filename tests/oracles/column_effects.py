#!/usr/bin/python3
"""Prints effect sizes and probabilities of tests/statistics/column_effects_test.cpp: the mean difference over
the standard deviation of differences with the paired t test, then over the pooled standard deviation with
Welch's t test. Needs scipy."""
import numpy as np
from scipy import stats

np.set_printoptions(precision=16)
first = np.array([[1.0, 10.0, -3.0], [2.5, 9.0, -2.5], [2.0, 14.0, -4.0], [4.0, 11.5, -3.25]])
second = np.array([[2.0, 9.5, -1.0], [2.25, 12.0, -2.0], [3.5, 8.0, -2.75],
                   [6.0, 9.0, -2.5], [5.0, 7.5, 0.5], [4.75, 10.0, -1.5]])

differences = second[:4] - first
print("paired", differences.mean(0) / differences.std(0, ddof=1), stats.ttest_rel(second[:4], first).pvalue)

squares = sum(((x - x.mean(0)) ** 2).sum(0) for x in (first, second))
pooled = np.sqrt(squares / (len(first) + len(second) - 2))
print("independent", (second.mean(0) - first.mean(0)) / pooled, stats.ttest_ind(second, first, equal_var=False).pvalue)
