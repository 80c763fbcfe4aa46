// SPDX-License-Identifier: MIT

#include "libshape/io/model_file.h"

#include <gtest/gtest.h>

#include <cmath>

#include "libshape/base/error.h"
#include "libshape/base/format.h"
#include "libshape/base/random.h"
#include "libshape/io/collection_file.h"
#include "tests/support/files.h"
#include "tests/support/h5py.h"
#include "tests/support/meshes.h"
#include "tests/support/spaces.h"

namespace shape {
using namespace internal;
namespace {

/// Three subjects, each calm and bumpy.
Collection paired_collection()
{
    const test::TestMesh first = test::bumpy_sphere(1, 0.1, 1);
    Collection collection{first.topology, {}, {}, {{"subject", {}}, {"state", {}}}};
    for (const char* state : {"calm", "bumpy"})
        for (unsigned subject = 1; subject <= 3; ++subject) {
            const double amplitude = state[0] == 'c' ? 0.1 : 0.3;
            collection.names.push_back(join("s", subject, "_", state));
            collection.points.push_back(test::bumpy_sphere(1, amplitude, subject).points);
            collection.labels[0].values.push_back(join("s", subject));
            collection.labels[1].values.push_back(state);
        }
    return collection;
}

const DifferenceOptions bumpy_minus_calm = {.pair_by = "subject",
                                            .from_label = "state",
                                            .from_value = "calm",
                                            .to_label = "state",
                                            .to_value = "bumpy"};

void expect_equal(const ShapeSpace& a, const ShapeSpace& b)
{
    ASSERT_EQ(a.index(), b.index());
    EXPECT_EQ(scale_of(a), scale_of(b));
    if (const EdgeSpace* edge = std::get_if<EdgeSpace>(&a)) {
        const EdgeSpace& other = std::get<EdgeSpace>(b);
        EXPECT_EQ(edge->coordinates, other.coordinates);
        EXPECT_EQ(edge->length_factors, other.length_factors);
        EXPECT_EQ(edge->dihedral_factors, other.dihedral_factors);
        EXPECT_EQ(edge->branch_angles, other.branch_angles);
        EXPECT_EQ(edge->position_factors, other.position_factors);
        EXPECT_EQ(edge->mean_positions, other.mean_positions);
    }
}

void expect_equal(const ShapeModel& a, const ShapeModel& b)
{
    EXPECT_TRUE(a.topology == b.topology);
    EXPECT_EQ(a.reference_points, b.reference_points);
    expect_equal(a.space, b.space);
    EXPECT_EQ(a.mean, b.mean);
    EXPECT_EQ(a.mean_dihedral_angles, b.mean_dihedral_angles);
    EXPECT_EQ(a.modes, b.modes);
    EXPECT_EQ(a.mode_dihedral_angles, b.mode_dihedral_angles);
    EXPECT_EQ(a.variances, b.variances);
    EXPECT_EQ(a.total_variance, b.total_variance);
    EXPECT_EQ(a.scores, b.scores);
    EXPECT_EQ(a.sizes, b.sizes);
    EXPECT_EQ(a.names, b.names);
    ASSERT_EQ(a.labels.size(), b.labels.size());
    for (std::size_t c = 0; c < a.labels.size(); ++c) {
        EXPECT_EQ(a.labels[c].name, b.labels[c].name);
        EXPECT_EQ(a.labels[c].values, b.labels[c].values);
    }
}

void expect_equal(const DifferenceVector& a, const DifferenceVector& b)
{
    EXPECT_TRUE(a.topology == b.topology);
    EXPECT_EQ(a.reference_points, b.reference_points);
    EXPECT_EQ(a.scale, b.scale);
    EXPECT_EQ(a.mean_edge_lengths, b.mean_edge_lengths);
    EXPECT_EQ(a.mean_dihedral_angles, b.mean_dihedral_angles);
    EXPECT_EQ(a.edge_lengths, b.edge_lengths);
    EXPECT_EQ(a.dihedral_angles, b.dihedral_angles);
    EXPECT_EQ(a.from_size, b.from_size);
    EXPECT_EQ(a.to_size, b.to_size);
    EXPECT_EQ(a.pairs, b.pairs);
}

TEST(ModelFile, GivesEveryBitBack)
{
    const test::TemporaryDirectory directory;
    for (const SpaceOptions& space : test::sample_spaces()) {
        const ModelOptions options{.modes = 2, .space = space};
        const ShapeModel model = fit_model(paired_collection(), options);
        write_model(directory / "m.h5", model, options);
        expect_equal(read_model(directory / "m.h5"), model);
        write_model(directory / "m.h5", model);
        expect_equal(read_model(directory / "m.h5"), model);
    }
    EXPECT_EQ(file_kind(directory / "m.h5"), FileKind::Model);
    EXPECT_EQ(directory.names(), std::vector<std::string>{"m.h5"});
}

TEST(DifferenceFile, GivesEveryBitBack)
{
    const test::TemporaryDirectory directory;
    const DifferenceVector difference = mean_difference(paired_collection(), bumpy_minus_calm);
    write_difference(directory / "d.h5", difference, bumpy_minus_calm);
    expect_equal(read_difference(directory / "d.h5"), difference);
    EXPECT_EQ(file_kind(directory / "d.h5"), FileKind::Difference);
    DifferenceOptions groups = bumpy_minus_calm;
    groups.pair_by.clear();
    const DifferenceVector unpaired = mean_difference(paired_collection(), groups);
    write_difference(directory / "d.h5", unpaired, groups);
    expect_equal(read_difference(directory / "d.h5"), unpaired);
}

TEST(ModelFile, HasTheSameBytesForTheSameModel)
{
    const test::TemporaryDirectory directory;
    const ShapeModel model = fit_model(paired_collection());
    write_model(directory / "a.h5", model);
    write_model(directory / "b.h5", model);
    EXPECT_EQ(test::read_bytes(directory / "a.h5"), test::read_bytes(directory / "b.h5"));
}

TEST(ModelFile, IsNotTakenForAnotherKind)
{
    const test::TemporaryDirectory directory;
    write_model(directory / "m.h5", fit_model(paired_collection()));
    const std::string message =
        test::message_of<InvalidInput>([&] { (void)read_collection(directory / "m.h5"); });
    EXPECT_NE(message.find("is 'libshape model', must be 'libshape collection'"), std::string::npos)
        << message;
    try {
        (void)read_difference(directory / "m.h5");
        ADD_FAILURE() << "no exception";
    } catch (const WrongFileKind& error) {
        EXPECT_EQ(error.wanted, FileKind::Difference);
    }
}

TEST(ModelFile, RefusesToWriteWhatItWouldNotRead)
{
    const test::TemporaryDirectory directory;
    const auto message = [&](const auto& spoil) {
        ShapeModel model = fit_model(paired_collection());
        spoil(model);
        return test::message_of<InvalidInput>([&] { write_model(directory / "m.h5", model); });
    };
    using M = ShapeModel;
    const std::vector<std::pair<std::string, std::string>> got = {
        {"/variances", message([](M& m) { m.variances.reverseInPlace(); })},
        {"/variances", message([](M& m) { m.variances.tail(1)[0] = -1e-9; })},
        {"/total_variance", message([](M& m) { m.total_variance *= 0.99; })},
        {"/total_variance", message([](M& m) { m.total_variance *= 1.01; })}, // it has all modes
        {"/modes/edge_lengths", message([](M& m) { m.modes(0, 0) += 1e-3; })},
        {"/modes/edge_lengths", message([](M& m) { m.modes.row(1) *= 2.0; })},
        {"/modes/edge_lengths", message([](M& m) { m.modes.row(1) = m.modes.row(0); })},
        {"/mean/edge_lengths", message([](M& m) { m.mean *= 1.001; })},
        {"/mean/edge_lengths", message([](M& m) { m.mean[3] *= -1.0; })},
        {"/sizes", message([](M& m) { m.sizes[2] = 0.0; })},
        {"/scores", message([](M& m) { m.scores(1, 0) = std::nan(""); })},
        {"/scores", message([](M& m) { m.scores.conservativeResize(5, Eigen::NoChange); })},
        {"twice", message([](M& m) { m.names[1] = m.names[0]; })},
    };
    for (const auto& [place, text] : got)
        EXPECT_NE(text.find(place), std::string::npos) << text;
    EXPECT_TRUE(directory.names().empty());
}

TEST(DifferenceFile, RefusesToWriteWhatItWouldNotRead)
{
    const test::TemporaryDirectory directory;
    const auto message = [&](const auto& spoil) {
        DifferenceVector difference = mean_difference(paired_collection(), bumpy_minus_calm);
        spoil(difference);
        return test::message_of<InvalidInput>(
            [&] { write_difference(directory / "d.h5", difference); });
    };
    using D = DifferenceVector;
    EXPECT_NE(message([](D& d) { d.from_size = 0.0; }).find("/from_size"), std::string::npos);
    EXPECT_NE(message([](D& d) { d.to_size = std::nan(""); }).find("/to_size"), std::string::npos);
    EXPECT_NE(message([](D& d) { d.edge_lengths[0] = INFINITY; }).find("/difference/edge_lengths"),
              std::string::npos);
    EXPECT_NE(message([](D& d) { d.edge_lengths[0] += 1e-6; }).find("must sum to 0"),
              std::string::npos);
    EXPECT_TRUE(directory.names().empty());
}

TEST(ModelFile, NeverGivesWrongValuesOfADamagedFile)
{
    const test::TemporaryDirectory directory;
    const ShapeModel model = fit_model(paired_collection(), {.modes = 2});
    const DifferenceVector difference = mean_difference(paired_collection(), bumpy_minus_calm);
    write_model(directory / "m.h5", model, ModelOptions{.modes = 2});
    write_difference(directory / "d.h5", difference, bumpy_minus_calm);
    const std::string model_bytes = test::read_bytes(directory / "m.h5");
    const std::string difference_bytes = test::read_bytes(directory / "d.h5");
    Random random(5);
    int refused = 0;
    const auto read_damaged = [&](std::string bytes, const auto& read_and_compare) {
        const std::size_t reach = random.index(2) == 0 ? bytes.size() : 4096;
        bytes[random.index(reach)] ^= static_cast<char>(1 << random.index(8));
        test::write_bytes(directory / "x.h5", bytes);
        try {
            read_and_compare();
        } catch (const InvalidInput&) {
            ++refused;
        }
    };
    for (int round = 0; round < 300; ++round) {
        read_damaged(model_bytes, [&] { expect_equal(read_model(directory / "x.h5"), model); });
        read_damaged(difference_bytes,
                     [&] { expect_equal(read_difference(directory / "x.h5"), difference); });
    }
    EXPECT_GT(refused, 300);
    for (std::size_t size = 0; size < model_bytes.size(); size += 211) {
        test::write_bytes(directory / "x.h5", model_bytes.substr(0, size));
        EXPECT_THROW((void)read_model(directory / "x.h5"), InvalidInput) << size;
    }
}

TEST(ModelFile, NamesFileDatasetAndRuleOfWhatItRefuses)
{
    if (test::python_with_h5py().empty())
        GTEST_SKIP() << "no Python with h5py";
    const std::vector<test::BadEdit> cases = {
        {"f.attrs['scale'] = np.bytes_('log')", "attribute scale", "'unit' or 'none'"},
        {"del f.attrs['scale']", "attribute scale", "missing"},
        {"del f['mean']", "/mean/edge_lengths", "missing"},
        {"v = f['scores'][...]; del f['scores']; f['scores'] = v[:, :1]", "/scores",
         "is 6 by 1, must be 6 by 2"},
        {"v = f['modes/edge_lengths'][...]; del f['modes/edge_lengths']; "
         "f['modes/edge_lengths'] = v[:, :100]",
         "/modes/edge_lengths", "is 2 by 100, must be 2 by 120"},
        {"v = f['variances'][...]; del f['variances']; f['variances'] = v[:0]", "/variances",
         "no values"},
        {"del f['total_variance']; f['total_variance'] = [1.0]", "/total_variance",
         "must be single value"},
        {"f['variances'][0] = f['variances'][1] / 2", "/variances", "descend"},
        {"f['variances'][1] = -1.0", "/variances", ">= 0"},
        {"f['total_variance'][()] = 0.0", "/total_variance", "at least the sum"},
        {"f['modes/edge_lengths'][0] *= 1.1", "/modes/edge_lengths", "orthonormal"},
        {"f['modes/edge_lengths'][0] += 0.1 * f['modes/edge_lengths'][1]", "/modes/edge_lengths",
         "orthonormal"},
        {"f['mean/edge_lengths'][0] *= 2", "/mean/edge_lengths", "sum to 1"},
        {"f['mean/edge_lengths'][0] = 0", "/mean/edge_lengths", "> 0"},
        {"f['sizes'][3] = -1.0", "/sizes", "> 0"},
        {"f['mean/dihedral_angles'][7] = np.nan", "/mean/dihedral_angles", "value (7) is nan"},
        {"f['reference_points'][3, 1] = np.inf", "/reference_points", "value (3, 1) is inf"},
        // Arrays that are sound by themselves, but not with one another.
        {"f['scores'][:, 1] *= 1.01", "/scores", "/variances give"},
        {"f['scores'][:, 0] += 0.01 * abs(f['scores'][:, 0]).max()", "/scores", "must have 0"},
        {"v = f['scores'][...]; f['scores'][...] = v[[1, 0, 2, 3, 4, 5]]", "/scores", "value (0, "},
        {"v = f['modes/edge_lengths'][...]; f['modes/edge_lengths'][...] = v[[1, 0]]", "/scores",
         "value (0, "},
        {"m = f['mean/edge_lengths'][...]; m[[0, 1]] = m[[1, 0]]; f['mean/edge_lengths'][...] = m",
         "/scores", "value (0, "},
        {"v = f['sizes'][...]; f['sizes'][...] = v[[1, 0, 2, 3, 4, 5]]", "/sizes", "value 0 is "},
    };
    const test::TemporaryDirectory directory;
    const auto read = [](const std::filesystem::path& file) { (void)read_model(file); };
    write_model(directory / "m.h5", fit_model(paired_collection(), {.modes = 2}));
    test::expect_refused(directory / "m.h5", cases, read);
    // Where the modes span the first mesh, the angles are known as well.
    write_model(directory / "all.h5", fit_model(paired_collection()));
    test::expect_refused(
        directory / "all.h5",
        {{"f['mean/dihedral_angles'][...] *= 1.01", "/modes/dihedral_angles", "at edge "},
         {"v = f['modes/dihedral_angles'][...]; f['modes/dihedral_angles'][...] = v[[1, 0, 2, 3, "
          "4]]",
          "/modes/dihedral_angles", "at edge "}},
        read);
}

TEST(ModelFile, HasTheCoordinatesOfItsSpaceUnderTheirName)
{
    if (test::python_with_h5py().empty())
        GTEST_SKIP() << "no Python with h5py";
    const test::TemporaryDirectory directory;
    const auto printed = [&](const SpaceOptions& space) {
        write_model(directory / "m.h5",
                    fit_model(paired_collection(), {.modes = 2, .space = space}));
        return test::run_h5py(directory / "m.h5", "r",
                              "print(f.attrs['space'].decode(), f.attrs['scale'].decode(), "
                              "f.attrs.get('coordinates'))\n"
                              "f.visititems(lambda n, d: print(n, d.shape) if n.startswith("
                              "('mean/', 'modes/', 'space/')) else None)\n");
    };
    EXPECT_EQ(printed({}),
              "edge unit None\nmean/dihedral_angles (120,)\nmean/edge_lengths (120,)\n"
              "modes/dihedral_angles (2, 120)\nmodes/edge_lengths (2, 120)\n");
    EXPECT_EQ(printed({.kind = SpaceKind::Procrustes, .scale = Scale::None}),
              "procrustes none None\nmean/points (42, 3)\nmodes/points (2, 42, 3)\n");
    EXPECT_EQ(printed({.coordinates = LengthCoordinates::Log,
                       .weighting = EdgeWeighting::Area,
                       .dihedral_weight = 0.5}),
              "edge unit b'log'\nmean/coordinates (240,)\nmodes/coordinates (2, 240)\n"
              "space/branch_angles (120,)\nspace/dihedral_factors (120,)\n"
              "space/length_factors (120,)\n");
    EXPECT_EQ(printed({.position_weight = 2.0}),
              "edge unit b'plain'\nmean/coordinates (246,)\nmean/dihedral_angles (120,)\n"
              "modes/coordinates (2, 246)\nmodes/dihedral_angles (2, 120)\n"
              "space/mean_positions (42, 3)\nspace/position_factors (42,)\n");
}

TEST(ModelFile, OfBeforeThereWasAChoiceIsOfEdgeSpace)
{
    if (test::python_with_h5py().empty())
        GTEST_SKIP() << "no Python with h5py";
    const test::TemporaryDirectory directory;
    const ShapeModel model = fit_model(paired_collection(), {.modes = 2});
    write_model(directory / "m.h5", model);
    const auto files = test::edit_with_h5py(directory / "m.h5", {"del f.attrs['space']"});
    expect_equal(read_model(files.front()), model);
}

TEST(ModelFile, NamesWhatItRefusesOfOtherSpaces)
{
    if (test::python_with_h5py().empty())
        GTEST_SKIP() << "no Python with h5py";
    struct Case
    {
        SpaceOptions space;
        std::string edit;
        std::string said;
    };
    const SpaceOptions procrustes{.kind = SpaceKind::Procrustes};
    const SpaceOptions weighted{.coordinates = LengthCoordinates::Squared,
                                .weighting = EdgeWeighting::Area,
                                .dihedral_weight = 0.5};
    const SpaceOptions placed{.position_weight = 2.0};
    const std::vector<Case> cases = {
        {procrustes, "f.attrs['space'] = np.bytes_('angles')",
         "attribute space: is 'angles', must be 'edge' or 'procrustes'"},
        {procrustes, "f.attrs['space'] = np.bytes_('edge')", "/mean/edge_lengths: is missing"},
        {procrustes, "v = f['mean/points'][...]; del f['mean/points']; f['mean/points'] = v[:5]",
         "/mean/points: is 5 by 3, must be 42 by 3"},
        {procrustes, "f['modes/points'][0] *= 2", "/modes/points: rows must be orthonormal"},
        {weighted, "f.attrs['coordinates'] = np.bytes_('cubic')",
         "attribute coordinates: is 'cubic', must be 'plain', 'squared' or 'log'"},
        {weighted, "f['space/length_factors'][7] = 0", "/space/length_factors: must be > 0"},
        {weighted, "f['space/dihedral_factors'][7] = -1", "/space/dihedral_factors: must be > 0"},
        {weighted, "del f['space/branch_angles']", "/space/branch_angles: is missing"},
        {weighted, "del f['space']", "/mean/coordinates: is 240, must be 120"},
        {placed, "f['space/position_factors'][7] = 0", "/space/position_factors: must be > 0"},
        {placed, "del f['space/mean_positions']", "/space/mean_positions: is missing"},
        {placed, "del f['space']", "/mean/edge_lengths: is missing"},
    };
    for (const Case& c : cases) {
        const test::TemporaryDirectory directory;
        write_model(directory / "m.h5",
                    fit_model(paired_collection(), {.modes = 2, .space = c.space}));
        const auto files = test::edit_with_h5py(directory / "m.h5", {c.edit});
        const std::string message =
            test::message_of<InvalidInput>([&] { (void)read_model(files.front()); });
        EXPECT_NE(message.find(c.said), std::string::npos) << message;
    }
}

TEST(ModelFile, TellsH5pyWhatWasAskedFor)
{
    if (test::python_with_h5py().empty())
        GTEST_SKIP() << "no Python with h5py";
    const test::TemporaryDirectory directory;
    const ModelOptions options{.modes = 2, .space = {.scale = Scale::None}};
    write_model(directory / "m.h5", fit_model(paired_collection(), options), options);
    EXPECT_EQ(
        test::run_h5py(directory / "m.h5", "r",
                       "a = f.attrs\n"
                       "print(a['scale'].decode(), a['asked_modes'], a['asked_variance'])\n"
                       "print(f['total_variance'][()] >= f['variances'][...].sum())\n"
                       "print(sorted(f), sorted(f['modes']))\n"),
        "none 2 1.0\nTrue\n['labels', 'mean', 'modes', 'names', 'reference_points', 'scores', "
        "'sizes', 'topology', 'total_variance', 'variances'] ['dihedral_angles', "
        "'edge_lengths']\n");
    write_difference(directory / "d.h5", mean_difference(paired_collection(), bumpy_minus_calm),
                     bumpy_minus_calm);
    EXPECT_EQ(
        test::run_h5py(directory / "d.h5", "r",
                       "a = f.attrs\n"
                       "print(a['pair_by'].decode(), a['from'].decode(), a['to'].decode())\n"
                       "print(list(f['pairs'].asstr()), f['difference/edge_lengths'].shape)\n"),
        "subject state=calm state=bumpy\n['s1', 's2', 's3'] (120,)\n");
}

} // namespace
} // namespace shape
