// SPDX-License-Identifier: MIT

#include "libshape/edge_space/procrustes.h"
#include "libshape/io/mesh_file.h"
#include "libshape/io/model_file.h"
#include "libshape/io/table_file.h"
#include "libshape/mesh/edge_lengths.h"
#include "tests/tools/program_test.h"

namespace shape::test {
namespace {

using Spaces = SilentProgramTest;

TEST_F(Spaces, AProcrustesModelGivesItsMeshesBackWithoutEmbedding)
{
    const Json figures =
        run({"stats", "a.ply", "b.ply", "c.ply", "-o", "m.h5", "--space", "procrustes"});
    EXPECT_EQ(figures["space"], "procrustes");
    EXPECT_EQ(figures["scale"], "unit");
    EXPECT_EQ(run({"info", "m.h5"})["space"], "procrustes");
    (void)run({"project", "m.h5", "a.ply", "b.ply", "c.ply", "-o", "s.csv"});
    const Json made = run({"generate", "m.h5", "--scores-file", "s.csv", "-o", "again"});
    for (const char* mesh : {"a.ply", "b.ply", "c.ply"}) {
        const Points before = points(mesh);
        const Points after = points(std::string("again/") + mesh);
        const Points centred = before.rowwise() - before.colwise().mean();
        EXPECT_LT((aligned_with(centred, after, Scale::None) - centred).norm(),
                  1e-9 * centred.norm());
    }
    EXPECT_EQ(made["embeddings"][0]["method"], "procrustes");
    EXPECT_EQ(made["embeddings"][0]["status"], "exact");
    EXPECT_EQ(made["embeddings"][0]["edge_max"], 0.0);
}

TEST_F(Spaces, AProcrustesModelMakesMeshesOfTheSizeAskedFor)
{
    (void)run({"stats", "a.ply", "b.ply", "c.ply", "-o", "m.h5", "--space", "procrustes"});
    (void)run({"generate", "m.h5", "--mean", "-o", "one.ply", "--size", "1"});
    (void)run({"generate", "m.h5", "--mean", "-o", "three.ply", "--size", "3"});
    EXPECT_LT((3.0 * points("one.ply") - points("three.ply")).norm(), 1e-12);
    EXPECT_NEAR(centroid_size(points("one.ply")), 1.0, 0.05); // the mean of unit meshes is smaller
}

TEST_F(Spaces, EveryChoiceOfCoordinatesComesBackFromItsScores)
{
    const std::vector<Arguments> choices = {{"--coordinates", "squared"},
                                            {"--coordinates", "log", "--area-weighted"},
                                            {"--with-dihedrals", "0.3"},
                                            {"--with-positions", "5"},
                                            {"--area-weighted", "--scale", "none"}};
    for (const Arguments& choice : choices) {
        SCOPED_TRACE(choice.front());
        const Json figures =
            run(Arguments{"stats", "a.ply", "b.ply", "c.ply", "--force", "-o", "m.h5"} + choice);
        EXPECT_EQ(figures["space"], "edge");
        (void)run({"project", "m.h5", "a.ply", "b.ply", "-o", "s.csv", "--force"});
        const Json made = run({"generate", "m.h5", "--scores-file", "s.csv", "-o", "n", "--force"});
        for (const Json& embedding : made["embeddings"])
            EXPECT_EQ(embedding["status"], "exact");
        const NamedMesh before = read_mesh(folder_ / "b.ply");
        const Topology topology(before.faces, static_cast<int>(before.points.rows()));
        const Eigen::VectorXd lengths = edge_lengths(topology, before.points);
        EXPECT_LT((edge_lengths(topology, points("n/b.ply")) - lengths).norm(),
                  1e-6 * lengths.norm());
    }
    EXPECT_EQ(run({"info", "m.h5"})["area_weighted"], true);
}

TEST_F(Spaces, DistancesAreAMatrixThatCarriesTheNames)
{
    const Json figures =
        run({"distance", "a.ply", "b.ply", "c.ply", "-o", "d.csv", "--metric", "edge"});
    EXPECT_EQ(figures["space"], "edge");
    EXPECT_EQ(figures["scale"], "none");
    const Table table = read_table(folder_ / "d.csv");
    EXPECT_EQ(table.columns, (Arguments{"mesh", "a", "b", "c"}));
    const NamedMesh first = read_mesh(folder_ / "a.ply");
    const Topology topology(first.faces, static_cast<int>(first.points.rows()));
    double largest = 0.0;
    for (std::size_t i = 0; i < 3; ++i)
        for (std::size_t j = 0; j < 3; ++j) {
            EXPECT_EQ(table.rows[i][0], table.columns[i + 1]);
            const double distance = (edge_lengths(topology, points(table.columns[i + 1] + ".ply")) -
                                     edge_lengths(topology, points(table.columns[j + 1] + ".ply")))
                                        .norm();
            EXPECT_NEAR(parse_number(table.rows[i][j + 1], "d"), distance, 1e-12);
            largest = std::max(largest, distance);
        }
    EXPECT_NEAR(figures["largest"].get<double>(), largest, 1e-12);
}

TEST_F(Spaces, MetricsAreShortForSpacesAndScales)
{
    const std::vector<std::pair<Arguments, Arguments>> same = {
        {{}, {"--metric", "edge-unit"}},
        {{"--space", "edge", "--scale", "none"}, {"--metric", "edge"}},
        {{"--space", "procrustes"}, {"--metric", "procrustes"}}};
    for (const auto& [long_form, short_form] : same) {
        const Arguments distance{"distance", "a.ply", "b.ply", "c.ply", "--force", "-o"};
        (void)run(distance + Arguments{"long.csv"} + long_form);
        (void)run(distance + Arguments{"short.csv"} + short_form);
        EXPECT_EQ(folder_.read("long.csv"), folder_.read("short.csv"));
    }
}

TEST_F(Spaces, QualityHasARowForEveryNumberOfModes)
{
    (void)run({"synth", "femurs", "--count", "8", "--vertices", "300", "-o", "bones"});
    for (const char* space : {"edge", "procrustes"}) {
        const Json figures = run({"quality", "bones", "-o", "q.csv", "--plot", "q.svg", "--modes",
                                  "1,3,5", "--samples", "4", "--space", space, "--force"});
        EXPECT_EQ(figures["folds"], 8); // one by one
        EXPECT_EQ(figures["tests"], 8);
        EXPECT_EQ(figures["decoded"], 3 * (8 + 4));
        const Table table = read_table(folder_ / "q.csv");
        EXPECT_EQ(
            table.columns,
            (Arguments{"modes", "compactness", "generalisation_vertex", "generalisation_vertex_sd",
                       "generalisation_edge", "generalisation_edge_sd", "specificity_vertex",
                       "specificity_vertex_sd", "specificity_edge", "specificity_edge_sd"}));
        ASSERT_EQ(table.rows.size(), 3U);
        const auto number = [&](std::size_t row, std::size_t column) {
            return parse_number(table.rows[row][column], "cell");
        };
        EXPECT_LT(number(0, 1), number(2, 1));
        EXPECT_GT(number(0, 2), number(2, 2));
        EXPECT_GT(number(0, 4), number(2, 4));
        EXPECT_EQ(figures["specificity_edge"][1].get<double>(), number(1, 8));
        EXPECT_NE(folder_.read("q.svg").find("Compactness"), std::string::npos);
    }
}

/// Mean distance of barbells that share their ends over that of those that share their bar.
double ends_over_bar(const Table& distances)
{
    const auto d = [&](std::size_t i, std::size_t j) {
        return parse_number(distances.rows[i][j + 1], "distance");
    };
    return (d(0, 1) + d(2, 3)) / (d(0, 2) + d(1, 3));
}

TEST_F(Spaces, BarbellsThatShareTheirEndsAreNearerByLengthsThanByPositions)
{
    // Rojas 2014, Fig. 7, for bars of several lengths and meshes of several sizes.
    for (const std::string vertices : {"400", "1500", "5000"}) {
        (void)run({"synth", "barbells", "--count", "8", "--vertices", vertices, "-o", "bells",
                   "--force"});
        for (const auto& [first, second] : std::vector<std::pair<std::string, std::string>>{
                 {"00", "01"}, {"00", "03"}, {"01", "02"}, {"02", "03"}}) {
            const Arguments meshes{
                "bells/barbell_a_" + first + ".ply", "bells/barbell_a_" + second + ".ply",
                "bells/barbell_b_" + first + ".ply", "bells/barbell_b_" + second + ".ply"};
            const auto ratio = [&](const Arguments& metric) {
                (void)run(Arguments{"distance"} + meshes + Arguments{"-o", "d.csv", "--force"} +
                          metric);
                return ends_over_bar(read_table(folder_ / "d.csv"));
            };
            const double positions = ratio({"--metric", "procrustes"});
            const double plain = vertices == "400" ? 1.0 : 0.9;
            EXPECT_LT(ratio({"--metric", "edge-unit"}), plain * positions)
                << vertices << " vertices, bars " << first << " and " << second;
            EXPECT_LT(ratio({"--metric", "edge-unit", "--area-weighted"}), 0.85 * positions)
                << vertices << " vertices, bars " << first << " and " << second;
        }
    }
}

TEST_F(Spaces, DistancesAreScaledClusteredAndDrawn)
{
    const Json figures = run({"distance", "a.ply", "b.ply", "c.ply", "--labels", "labels.csv", "-o",
                              "d.csv", "--mds", "mds.csv", "--plot", "mds.svg", "--cluster",
                              "order.csv", "--heat-map", "map.svg", "--color-by", "mood"});
    EXPECT_EQ(figures["outputs"], Json({"d.csv", "mds.csv", "mds.svg", "order.csv", "map.svg"}));
    EXPECT_NEAR(figures["mds_share"].get<double>(), 1.0, 1e-12); // three meshes lie in a plane
    const Table matrix = read_table(folder_ / "d.csv");
    const Table plane = read_table(folder_ / "mds.csv");
    EXPECT_EQ(plane.columns, (Arguments{"mesh", "subject", "mood", "mds1", "mds2"}));
    const auto number = [](const std::string& cell) { return parse_number(cell, "cell"); };
    for (std::size_t i = 0; i < 3; ++i)
        for (std::size_t j = 0; j < 3; ++j)
            EXPECT_NEAR(std::hypot(number(plane.rows[i][3]) - number(plane.rows[j][3]),
                                   number(plane.rows[i][4]) - number(plane.rows[j][4])),
                        number(matrix.rows[i][j + 1]), 1e-12);
    const Table order = read_table(folder_ / "order.csv");
    EXPECT_EQ(order.columns, (Arguments{"mesh", "subject", "mood", "joins_at"}));
    EXPECT_EQ(order.rows[0][0], "a");
    EXPECT_EQ(order.rows[0][3], "0");
    for (const char* drawing : {"mds.svg", "map.svg"})
        EXPECT_NE(folder_.read(drawing).find("glad"), std::string::npos) << drawing;
}

} // namespace
} // namespace shape::test
