# SPDX-License-Identifier: MIT
"""A small morphometrics study: do expressions differ, along which modes, and who is odd?

Run it in an empty folder; it makes its own faces. With your own: ls.read("meshes/", labels="labels.csv").
"""
# %% The meshes: 8 people, each neutral, happy and angry
import libshape as ls

faces = ls.synthetic("faces", count=8, vertices=500)
print(faces)

# %% Mean and modes of the shapes, which need no alignment
model = faces.model(variance=0.95)
print(model)
for k, share in enumerate(model.variances / model.total_variance):
    print(f"mode {k + 1}: {100 * share:.1f} % of the variance")

# %% Do the expressions differ? Labels are permuted within each person
groups = ls.groups(faces, by="expression", within="subject", permutations=199)
print(groups)
for pair in groups.pairs:
    print(f"{pair.first} - {pair.second}: distance {pair.distance:.3g}, p = {pair.adjusted_p:.3g}")

# %% Who is far from the others?
distances = ls.distance(faces)
mean_distance = distances.matrix.sum(axis=1) / (len(faces) - 1)
print("farthest from the others:", distances.names[int(mean_distance.argmax())])

# %% The scores as a table for R, a spreadsheet or pandas
scores = model.scores(faces)
columns = scores.as_dict()
with open("scores.csv", "w", encoding="utf-8") as file:
    print(*columns, sep=",", file=file)
    for row in zip(*columns.values()):
        print(*row, sep=",", file=file)

# %% Meshes two standard deviations along the first mode
for sigma in (-2, 0, 2):
    mesh, report = model.decode([sigma])
    print(sigma, mesh, report)
    mesh.write(f"mode1_{sigma}.ply")
