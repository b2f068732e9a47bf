#!/usr/bin/env python3
"""Fits atan(a) on [0, 1] by a + a^3 (c0 + c1 a^2 + c2 a^4) with the least largest error (Remez exchange).

Prints the coefficients of vision/elementary_motion.hpp and the error that is left.
"""
import numpy as np

grid = np.linspace(0.0, 1.0, 200001)
nodes = np.array([0.3, 0.6, 0.85, 1.0])
for _ in range(50):
    rows = np.column_stack([nodes**3, nodes**5, nodes**7, [1, -1, 1, -1]])
    c = np.linalg.solve(rows, np.arctan(nodes) - nodes)[:3]
    error = np.arctan(grid) - grid - (c[0] * grid**3 + c[1] * grid**5 + c[2] * grid**7)
    turns = [i for i in range(1, len(grid) - 1)
             if (error[i] - error[i - 1]) * (error[i + 1] - error[i]) <= 0] + [len(grid) - 1]
    turns = sorted(sorted(turns, key=lambda i: -abs(error[i]))[:4])
    if np.allclose(grid[turns], nodes, atol=1e-5):
        break
    nodes = grid[turns]
print("kAtan0 = %.9gf, kAtan1 = %.9gf, kAtan2 = %.9gf" % tuple(np.float32(c)))
print("largest error %.3g rad" % np.max(np.abs(error)))
