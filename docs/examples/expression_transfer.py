# SPDX-License-Identifier: MIT
"""Expression transfer: the smile of some people, learnt and put on somebody else (Rojas 2014, Fig. 10)."""
# %% Seven people to learn from, one to smile
import libshape as ls

faces = ls.synthetic("faces", count=8, vertices=500)
last = faces.labels["subject"][-1]
others = faces[[i for i, subject in enumerate(faces.labels["subject"]) if subject != last]]
(stranger,) = (
    faces[i]
    for i in range(len(faces))
    if faces.labels["subject"][i] == last and faces.labels["expression"][i] == "neutral"
)

# %% The mean difference between the same people neutral and happy
smile = ls.difference(
    others, "expression=neutral", "expression=happy", pair_by="subject"
)
print(smile)

# %% On the stranger: half a smile, the usual one, and a broad one
for amount in (0.5, 1.0, 1.5):
    mesh, report = smile.apply(stranger, amount)
    print(amount, mesh, report)
    mesh.write(f"smile_{amount}.ply")
