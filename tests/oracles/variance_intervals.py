#!/usr/bin/python3
"""Prints how often 95 % percentile intervals of bootstrapped variances hold the true one, lie below it and above it, and the mean of
the resampled variances over the estimate (docs/groups.md): of one normal coordinate, and of the first mode of thirty whose variances
are 1 / k^2. Needs numpy; half a minute."""
import numpy as np

random = np.random.default_rng(1)


def first_variance(x):
    centred = x - x.mean(axis=-2, keepdims=True)
    if x.shape[-1] == 1:
        return (centred[..., 0] ** 2).sum(axis=-1) / (x.shape[-2] - 1)
    return np.linalg.eigvalsh(centred @ centred.swapaxes(-1, -2))[..., -1] / (x.shape[-2] - 1)


for name, variances, repetitions in (("one coordinate", np.ones(1), 2000), ("first of 1 / k^2", np.arange(1, 31.0) ** -2, 200)):
    for n in (3, 5, 10, 20, 30, 50, 100) if len(variances) == 1 else (5, 10, 20, 30):
        outcome = np.zeros(3)
        ratio = 0.0
        for _ in range(repetitions):
            x = random.normal(size=(n, len(variances))) * np.sqrt(variances)
            drawn = first_variance(x[random.integers(n, size=(399, n))])
            low, high = np.quantile(drawn, (0.025, 0.975))
            outcome += (low <= variances[0] <= high, high < variances[0], low > variances[0])
            ratio += drawn.mean() / first_variance(x) / repetitions
        print(f"{name}, n = {n}: held {100 * outcome[0] / repetitions:.0f} %, below {100 * outcome[1] / repetitions:.0f} %, "
              f"above {100 * outcome[2] / repetitions:.0f} %, resampled {ratio:.2f} of the estimate", flush=True)
