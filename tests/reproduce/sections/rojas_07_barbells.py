# SPDX-License-Identifier: MIT
"""Rojas 2014, Fig. 7: which barbells are alike, by lengths and by positions."""
import itertools

TITLE = "Barbells (Rojas 2014, Fig. 7)"
BARS = 6
RESOLUTIONS = (300, 1500, 6000, 24000)
METRICS = {"lengths": ["--metric", "edge-unit"],
           "weighted": ["--metric", "edge-unit", "--area-weighted"],
           "positions": ["--metric", "procrustes"]}


def ratio(distances, names):
    """Mean distance of those that share their ends over that of those that share their bar."""
    (a_short, a_long), (b_short, b_long) = names
    ends = distances[a_short, a_long] + distances[b_short, b_long]
    bar = distances[a_short, b_short] + distances[a_long, b_long]
    return ends / bar


def four_way(run):
    """The table of the figure: four barbells in both spaces."""
    run.shape("synth", "barbells", "-o", "four")
    names = ["a_short", "a_long", "b_short", "b_long"]
    text = ""
    for metric, title, picture in (("edge-unit", "Unit-sum edge lengths", "edge"),
                                   ("procrustes", "Aligned RMS distance", "procrustes")):
        distances = run.distances(["four"], "--labels", "four/labels.csv", "--metric", metric,
                                  "--heat-map", run.images / f"barbells_{picture}.svg",
                                  "--color-by", "ends")
        largest = max(distances.values())
        rows = [[f"`{name}`"] + [f"{distances['barbell_' + name, 'barbell_' + other] / largest:.2f}"
                                 for other in names] for name in names]
        pairs = [["barbell_a_short", "barbell_a_long"], ["barbell_b_short", "barbell_b_long"]]
        text += (f"{title}, the largest as 1; same ends over same bar: "
                 f"**{ratio(distances, pairs):.2f}**\n\n"
                 + table([""] + [f"`{name}`" for name in names], rows) + "\n")
    return text


def over_a_range(run):
    """The ratio for all pairs out of several bars, on meshes of several sizes."""
    cells = {}
    shown = []
    for vertices in RESOLUTIONS:
        made = run.shape("synth", "barbells", "--count", 2 * BARS, "--vertices", vertices,
                         "-o", "bells")
        shown.append(made["vertices"])
        for pair in itertools.combinations(range(BARS), 2):
            names = [[f"barbell_{ends}_{bar:02}" for bar in pair] for ends in "ab"]
            files = [f"bells/{name}.ply" for row in names for name in row]
            cells[pair, vertices] = {metric: ratio(run.distances(files, *options), names)
                                     for metric, options in METRICS.items()}
    lengths = [12.0 ** (i / (BARS - 1)) for i in range(BARS)]
    rows = []
    for pair in itertools.combinations(range(BARS), 2):
        rows.append([f"{lengths[pair[0]]:.1f} and {lengths[pair[1]]:.1f}"] +
                    [" : ".join(f"{value:.2f}" for value in cells[pair, vertices].values())
                     for vertices in RESOLUTIONS])

    def against_positions(metric):
        quotients = [cell[metric] / cell["positions"] for cell in cells.values()]
        return f"{min(quotients):.2f} to {max(quotients):.2f} times"

    return (table(["bars"] + [f"{count} vertices" for count in shown], rows),
            against_positions("lengths"), against_positions("weighted"))


def make(run):
    grid, lengths, weighted = over_a_range(run)
    return f"""Two kinds of ends (`a` round, `b` lobed) on a short and a long bar. The paper's claim: by aligned RMS
distance "the size difference dominates"; by edge lengths, with scale taken away, "the distances become more
comparable". The measure of that here is the mean distance of barbells that share their ends over the mean
distance of those that share their bar: large where the bar decides, 1 where ends and bar count alike.

{four_way(run)}
![By lengths](images/barbells_edge.svg) ![By positions](images/barbells_procrustes.svg)

As in the paper, the bar decides by positions, and by lengths ends and bar become more comparable. In neither space
are barbells with the same ends the nearest ones: unit-sum lengths of a whole barbell still shrink with the
length of its bar.

The same ratio, lengths : lengths weighted by area : positions, for all pairs out of {BARS} bars of lengths from 1 to
12 (the ends are about 2 wide) on meshes of several sizes:

{grid}
By lengths the ratio is smaller everywhere, {lengths} that by positions. The two come close where long bars meet
coarse meshes: the number of edges on the bar is the same for every bar, so those of a long one are long, and
plain squared differences count them for what they are. Weighted by the area around each edge (`--area-weighted`) the
ratio is {weighted} that by positions, on coarse meshes as on fine ones.
"""
