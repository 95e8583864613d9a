"""Computes src/base/colour/uplift.csv: three reflectances that stand for red, green and blue.

The idea is that of Mallett and Yuksel, "Spectral Primary Decomposition for Rendering with sRGB Reflectance" (EGSR 2019):
smooth functions R, G, B >= 0 of wavelength whose sum is 1 everywhere and whose colours under D65 are the primaries of
Rec.709. The table is our own: nodes every 5 nm from 360 to 830 nm, linear between them, the least sum of squared second
differences subject to

    R >= 0, B >= 0, G = 1 - R - B >= 0
    sum over 1 nm of D65 * cmf * R = (share of red in the Rec.709 colour of D65) * red primary, and so for B.

(G's own colour then follows, since the three add up to D65.) An interior-point method finds which bounds are active; the
solution with exactly those active is then solved for directly, so that the sums hold to rounding.

usage: python3 tests/python/uplift_basis.py > src/base/colour/uplift.csv   (needs numpy)
"""

import csv
import pathlib
import sys

import numpy as np

HERE = pathlib.Path(__file__).resolve().parents[2] / "src/base/colour"


def rows(name):
    lines = [line for line in open(HERE / name, encoding="utf-8") if not line.startswith("#")]
    return list(csv.reader(lines))[1:]


nm = np.arange(360, 831)
cmf = np.array([[float(x) for x in row[1:4]] for row in rows("cmf.csv")])
table = [(float(row[0]), float(row[1])) for row in rows("illuminants.csv") if row[1]]
d65 = np.interp(nm, *zip(*table), left=0.0, right=0.0)
node = np.arange(360, 831, 5)
N = len(node)
# Node values -> values each nm.
lerp = np.stack([np.interp(nm, node, np.eye(N)[i]) for i in range(N)], axis=1)

# Rec.709 primaries and D65 white (ITU-R BT.709): linear RGB -> XYZ.
xy = np.array([[0.64, 0.33], [0.30, 0.60], [0.15, 0.06]])
p = np.array([[x / y, 1.0, (1 - x - y) / y] for x, y in xy]).T
w = np.array([0.3127 / 0.3290, 1.0, (1 - 0.3127 - 0.3290) / 0.3290])
to_rgb = np.linalg.inv(p * np.linalg.solve(p, w))

weight = to_rgb @ (cmf * d65[:, None]).T  # 3 x 471: Rec.709 of light of each nm, times a constant
weight /= d65 @ cmf[:, 1]
white = weight.sum(axis=1)  # of D65 itself: nearly 1

# Unknowns x = [R nodes, B nodes].
A = np.zeros((6, 2 * N))
A[:3, :N] = weight @ lerp
A[3:, N:] = weight @ lerp
b = np.concatenate([[white[0], 0, 0], [0, 0, white[2]]])
D = np.diff(np.eye(N), n=2, axis=0)
Q = np.block([[2 * D.T @ D, D.T @ D], [D.T @ D, 2 * D.T @ D]])  # |DR|^2 + |DB|^2 + |D(R + B)|^2
I, O = np.eye(N), np.zeros((N, N))
C = np.block([[I, O], [O, I], [-I, -I]])  # C x + d >= 0
d = np.concatenate([np.zeros(2 * N), np.ones(N)])

x = np.full(2 * N, 1 / 3)
s = np.maximum(C @ x + d, 0.1)
z = np.ones(3 * N)
y = np.zeros(6)
for step in range(200):
    mu = s @ z / len(s) * 0.1
    rd = Q @ x - A.T @ y - C.T @ z
    rp, rs = A @ x - b, C @ x + d - s
    K = np.block([[Q + C.T @ ((z / s)[:, None] * C) + 1e-13 * np.eye(2 * N), -A.T], [A, np.zeros((6, 6))]])
    r = -rd + C.T @ ((mu - z * rs) / s - z)
    sol = np.linalg.solve(K, np.concatenate([r, -rp]))
    dx, dy = sol[: 2 * N], sol[2 * N :]
    ds = C @ dx + rs
    dz = (mu - z * ds) / s - z
    a = min([1.0] + [0.99 * -v / dv for v, dv in zip(np.concatenate([s, z]), np.concatenate([ds, dz])) if dv < 0])
    x, y, s, z = x + a * dx, y + a * dy, s + a * ds, z + a * dz
    if s @ z / len(s) < 1e-18 and abs(rp).max() < 1e-13:
        break

active = z > s
for _ in range(20):
    # The active bounds as equalities; least curvature for the rest.
    E = np.vstack([A, C[active]])
    e = np.concatenate([b, -d[active]])
    K = np.block([[Q, E.T], [E, np.zeros((len(e), len(e)))]])
    x = np.linalg.lstsq(K, np.concatenate([np.zeros(2 * N), e]), rcond=1e-15)[0][: 2 * N]
    # One Newton correction for the sums to hold to rounding.
    x -= np.linalg.lstsq(E, E @ x - e, rcond=1e-15)[0]
    below = C @ x + d < -1e-15
    if not (below & ~active).any():
        break
    active |= below
x[np.where(active[: 2 * N])[0]] = 0.0
R, B = x[:N], x[N:]
full = active[2 * N :]
B[full & (B > 0)] = 1.0 - R[full & (B > 0)]
R[full & (B == 0)] = 1.0
R, B = np.maximum(R, 0.0), np.maximum(B, 0.0)
# D65 is tabulated to 780 nm: nothing holds the rest but smoothness.
R[node > 780], B[node > 780] = R[node == 780], B[node == 780]
G = 1.0 - R - B
assert G.min() >= -1e-15, G.min()
worst = np.abs(A @ np.concatenate([R, B]) - b).max()
print("steps", step, "curvature", float(x @ Q @ x), "worst constraint", worst, "white", white, file=sys.stderr)

print("# Reflectances of red and blue for RGB uplift, linear between the nodes; green is 1 - red - blue.")
print("# Computed by tests/python/uplift_basis.py, which says what they are; under D65 and CIE 1931 by 1 nm.")
print("nm,red,blue")
for at, r, b_ in zip(node, R, B):
    print(f"{at},{float(r)!r},{float(b_)!r}")
