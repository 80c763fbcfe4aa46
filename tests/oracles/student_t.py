#!/usr/bin/python3
"""Prints the two-sided tail probabilities of tests/statistics/student_t_test.cpp: t, degrees of freedom n,
P(|T| >= |t|) = I_x(n / 2, 1 / 2) with x = n / (n + t^2), the regularised incomplete beta function in forty
digits. Needs mpmath."""
from mpmath import betainc, mp, mpf, nstr

mp.dps = 40
for t, n in [(0.001, 0.5), (0.3, 2.7), (1.0, 7.5), (2.5, 12.25), (40.0, 3.5), (6.0, 199.0), (25.0, 199.0),
             (1.96, 1e4), (100.0, 50.0)]:
    x = mpf(n) / (mpf(n) + mpf(t) ** 2)
    print(t, n, nstr(betainc(mpf(n) / 2, mpf(1) / 2, 0, x, regularized=True), 20))
