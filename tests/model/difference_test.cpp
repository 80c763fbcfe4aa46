// SPDX-License-Identifier: MIT

#include "libshape/model/difference.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "libshape/base/error.h"
#include "tests/support/collections.h"
#include "tests/support/files.h"

namespace shape {
namespace {

/// Three people, two of them in both poses: 0 and 3 are Bert, 1 and 4 Anna; 2 is Cleo at rest.
Collection people()
{
    Collection collection = test::bumpy_spheres(5, 1);
    collection.labels = {{"person", {"bert", "anna", "cleo", "bert", "anna"}},
                         {"pose", {"rest", "rest", "rest", "bent", "bent"}}};
    return collection;
}

DifferenceOptions rest_to_bent(Scale scale = Scale::Unit)
{
    return {.pair_by = "person",
            .from_label = "pose",
            .from_value = "rest",
            .to_label = "pose",
            .to_value = "bent",
            .scale = scale};
}

/// The message of mean_difference() for these options, or for this collection.
std::string message_for(const DifferenceOptions& options, const Collection& collection = people())
{
    try {
        (void)mean_difference(collection, options);
    } catch (const InvalidInput& error) {
        return error.what();
    }
    return "nothing was thrown";
}

TEST(MeanDifference, IsTheMeanOverThePairs)
{
    for (const Scale scale : {Scale::Unit, Scale::None}) {
        const Collection collection = people();
        const ShapeVectors v = shape_vectors(collection, scale);
        const DifferenceVector d = mean_difference(collection, rest_to_bent(scale));
        EXPECT_EQ(d.pairs, (std::vector<std::string>{"anna", "bert"}));
        const auto mean = [](const RowMatrix& m, int a, int b) -> Eigen::VectorXd {
            return 0.5 * (m.row(a) + m.row(b)).transpose();
        };
        const Eigen::VectorXd from = mean(v.edge_lengths, 0, 1);
        const Eigen::VectorXd from_angles = mean(v.dihedral_angles, 0, 1);
        EXPECT_LE((d.mean_edge_lengths - from).norm(), 1e-14);
        EXPECT_LE((d.edge_lengths - (mean(v.edge_lengths, 3, 4) - from)).norm(), 1e-14);
        EXPECT_LE((d.mean_dihedral_angles - from_angles).norm(), 1e-14);
        EXPECT_LE((d.dihedral_angles - (mean(v.dihedral_angles, 3, 4) - from_angles)).norm(),
                  1e-14);
        EXPECT_DOUBLE_EQ(d.from_size, 0.5 * (v.sizes[0] + v.sizes[1]));
        EXPECT_DOUBLE_EQ(d.to_size, 0.5 * (v.sizes[3] + v.sizes[4]));
        EXPECT_EQ(d.reference_points, collection.points[1]);
        EXPECT_EQ(d.scale, scale);
    }
}

TEST(MeanDifference, IsNegatedWhenTheGroupsChangePlaces)
{
    const DifferenceVector there = mean_difference(people(), rest_to_bent());
    DifferenceOptions back = rest_to_bent();
    std::swap(back.from_value, back.to_value);
    const DifferenceVector here = mean_difference(people(), back);
    EXPECT_LE((there.edge_lengths + here.edge_lengths).norm(), 1e-16);
    EXPECT_LE((there.dihedral_angles + here.dihedral_angles).norm(), 1e-13);
}

TEST(MeanDifference, DoesNotDependOnMeshesWithoutAPartner)
{
    Collection fewer = people();
    fewer.names.erase(fewer.names.begin() + 2);
    fewer.points.erase(fewer.points.begin() + 2);
    for (LabelColumn& column : fewer.labels)
        column.values.erase(column.values.begin() + 2);
    const DifferenceVector all = mean_difference(people(), rest_to_bent());
    const DifferenceVector some = mean_difference(fewer, rest_to_bent());
    EXPECT_EQ(all.edge_lengths, some.edge_lengths);
    EXPECT_EQ(all.mean_dihedral_angles, some.mean_dihedral_angles);
}

TEST(MeanDifference, TakesTheMeanOfRepeatedScans)
{
    Collection collection = test::bumpy_spheres(6, 3);
    collection.labels = {{"person", {"anna", "bert", "anna", "bert", "anna", "bert"}},
                         {"pose", {"rest", "rest", "rest", "bent", "bent", "bent"}}};
    const ShapeVectors v = shape_vectors(collection, Scale::None);
    const DifferenceVector d = mean_difference(collection, rest_to_bent(Scale::None));
    const auto row = [&](int i) { return v.edge_lengths.row(i); };
    const RowMatrix anna = row(4) - 0.5 * (row(0) + row(2));
    const RowMatrix bert = 0.5 * (row(3) + row(5)) - row(1);
    EXPECT_LE((d.edge_lengths.transpose() - 0.5 * (anna + bert)).norm(), 1e-13);
    EXPECT_NEAR(d.from_size, 0.25 * (v.sizes[0] + v.sizes[2]) + 0.5 * v.sizes[1], 1e-12);
    EXPECT_EQ(d.pairs, (std::vector<std::string>{"anna", "bert"}));
    // t = m / s of the two differences.
    const ColumnEffects effects = difference_effects(collection, rest_to_bent(Scale::None));
    const double a = anna(0, 0);
    const double b = bert(0, 0);
    EXPECT_NEAR(effects.effects[0], 0.5 * (a + b) / (std::abs(a - b) / std::sqrt(2.0)), 1e-9);
}

TEST(MeanDifference, SaysWhatIsMissing)
{
    DifferenceOptions options = rest_to_bent();
    options.pair_by = "name";
    EXPECT_EQ(message_for(options), "no label column 'name'; the collection has person, pose");
    options = rest_to_bent();
    options.to_label = "posture";
    EXPECT_EQ(message_for(options), "no label column 'posture'; the collection has person, pose");
    options = rest_to_bent();
    options.from_value = "sleep";
    EXPECT_EQ(message_for(options), "difference: no mesh has pose = 'sleep' and a value of person");

    Collection collection = people();
    collection.labels[0].values = {"anna", "bert", "cleo", "dora", "emil"};
    EXPECT_EQ(message_for(rest_to_bent(), collection),
              "difference: no person has both pose = 'rest' and pose = 'bent'");
}

/// The difference added to the mean it starts from.
ShapePoint applied(const DifferenceVector& difference, double amount, double size)
{
    return apply_differences(start_of(difference, size), {difference}, {amount});
}

TEST(ApplyDifferences, StartsAtTheMeanAndEndsAtTheMeanOfTheOtherGroup)
{
    const Collection collection = people();
    const ShapeVectors v = shape_vectors(collection, Scale::Unit);
    const DifferenceVector d = mean_difference(collection, rest_to_bent());
    const ShapePoint start = applied(d, 0.0, 7.0);
    EXPECT_LE((start.edge_lengths - 7.0 * d.mean_edge_lengths).norm(), 1e-15);
    EXPECT_NEAR(start.edge_lengths.sum(), 7.0, 1e-13);
    EXPECT_EQ(start.dihedral_angles, d.mean_dihedral_angles);
    const ShapePoint end = applied(d, 1.0, 7.0);
    EXPECT_LE((end.edge_lengths.transpose() - 3.5 * (v.edge_lengths.row(3) + v.edge_lengths.row(4)))
                  .norm(),
              1e-14);
    const ShapePoint middle = applied(d, 0.5, 7.0);
    EXPECT_LE((2.0 * middle.edge_lengths - start.edge_lengths - end.edge_lengths).norm(), 1e-14);
    EXPECT_LE((2.0 * middle.dihedral_angles - start.dihedral_angles - end.dihedral_angles).norm(),
              1e-13);
}

TEST(ApplyDifferences, TakesTheStartOfOneMeshOfAPairToItsEnd)
{
    // With one pair the difference is that of its two meshes; sizes differ, that of the start stays.
    Collection collection = people();
    collection.labels[0].values = {"bert", "anna", "cleo", "bert", "dora"};
    const ShapeVectors v = shape_vectors(collection, Scale::None);
    const auto point = [&](int mesh) {
        return ShapePoint{v.edge_lengths.row(mesh), v.dihedral_angles.row(mesh)};
    };
    const ShapePoint unit =
        apply_differences(point(0), {mean_difference(collection, rest_to_bent())}, {1.0});
    EXPECT_LE((unit.edge_lengths - v.sizes[0] / v.sizes[3] * point(3).edge_lengths).norm(),
              1e-13 * v.sizes[0]);
    EXPECT_LE((unit.dihedral_angles - point(3).dihedral_angles).norm(), 1e-13);
    const ShapePoint plain = apply_differences(
        point(0), {mean_difference(collection, rest_to_bent(Scale::None))}, {1.0});
    EXPECT_LE((plain.edge_lengths - point(3).edge_lengths).norm(), 1e-13 * v.sizes[0]);
}

TEST(ApplyDifferences, AddsSeveralAtOnceInAnyOrder)
{
    const DifferenceVector bent = mean_difference(people(), rest_to_bent());
    DifferenceVector other = bent;
    other.edge_lengths = bent.edge_lengths.reverse();
    other.dihedral_angles = bent.dihedral_angles.reverse();
    const ShapePoint start = start_of(bent, 3.0);
    const ShapePoint both = apply_differences(start, {bent, other}, {0.5, -0.2});
    const ShapePoint steps =
        apply_differences(apply_differences(start, {other}, {-0.2}), {bent}, {0.5});
    EXPECT_LE((both.edge_lengths - steps.edge_lengths).norm(), 1e-14);
    EXPECT_LE((both.dihedral_angles - steps.dihedral_angles).norm(), 1e-13);
    EXPECT_NEAR(both.edge_lengths.sum(), 3.0, 1e-13);
    EXPECT_EQ(apply_differences(start, {}, {}).edge_lengths, start.edge_lengths);
}

TEST(ApplyDifferences, IgnoresSizeWhereLengthsAreNotScaled)
{
    const DifferenceVector d = mean_difference(people(), rest_to_bent(Scale::None));
    EXPECT_EQ(applied(d, 0.0, -3.0).edge_lengths, d.mean_edge_lengths);
    EXPECT_EQ(applied(d, 2.0, 1.0).edge_lengths, applied(d, 2.0, 5.0).edge_lengths);
}

TEST(ApplyDifferences, RefusesWhatBreaksARule)
{
    const double nan = std::numeric_limits<double>::quiet_NaN();
    const DifferenceVector d = mean_difference(people(), rest_to_bent());
    EXPECT_THROW((void)applied(d, nan, 1.0), InvalidInput);
    for (const double size : {0.0, -1.0, nan})
        EXPECT_THROW((void)start_of(d, size), InvalidInput);
    const ShapePoint start = start_of(d, 1.0);
    EXPECT_THROW((void)apply_differences(start, {d}, {1.0, 1.0}), InvalidInput);
    const ShapePoint shorter{start.edge_lengths.head(9), start.dihedral_angles.head(9)};
    EXPECT_THROW((void)apply_differences(shorter, {d}, {1.0}), InvalidInput);
    const DifferenceVector plain = mean_difference(people(), rest_to_bent(Scale::None));
    EXPECT_THROW((void)apply_differences(start, {d, plain}, {1.0, 1.0}), InvalidInput);
    DifferenceVector other = d;
    Faces turned = d.topology.faces();
    turned.col(1).swap(turned.col(2));
    other.topology = Topology(turned, d.topology.vertex_count());
    EXPECT_THROW((void)apply_differences(start, {d, other}, {1.0, 1.0}), InvalidInput);
}

TEST(DifferenceEffects, AreThePairedEffectsOfTheShapeVectors)
{
    for (const Scale scale : {Scale::Unit, Scale::None}) {
        const Collection collection = people();
        const RowMatrix lengths = shape_vectors(collection, scale).edge_lengths;
        RowMatrix from(2, lengths.cols());
        RowMatrix to(2, lengths.cols());
        from << lengths.row(1), lengths.row(0);
        to << lengths.row(4), lengths.row(3);
        const ColumnEffects effects = difference_effects(collection, rest_to_bent(scale));
        const ColumnEffects expected = paired_effects(from, to);
        EXPECT_LE((effects.effects - expected.effects).norm(), 1e-9 * expected.effects.norm());
        EXPECT_LE((effects.probabilities - expected.probabilities).norm(), 1e-9);
    }
}

TEST(DifferenceEffects, NeedTwoPairs)
{
    Collection collection = people();
    collection.labels[0].values[4] = "dora";
    EXPECT_EQ(mean_difference(collection, rest_to_bent()).pairs.size(), 1U);
    EXPECT_NE(test::message_of<InvalidInput>([&] {
                  (void)difference_effects(collection, rest_to_bent());
              }).find("effects need two or more meshes, or pairs of them; of "),
              std::string::npos);
    DifferenceOptions same = rest_to_bent();
    same.to_value = same.from_value;
    EXPECT_NE(message_for(same).find("another group"), std::string::npos) << message_for(same);
    DifferenceOptions unknown = rest_to_bent();
    unknown.pair_by = "name";
    EXPECT_THROW((void)difference_effects(collection, unknown), InvalidInput);
}

/// Three women and two men, nobody twice.
Collection strangers()
{
    Collection collection = test::bumpy_spheres(5, 1);
    collection.labels = {{"sex", {"f", "m", "f", "m", "f"}}};
    return collection;
}

DifferenceOptions women_to_men(Scale scale)
{
    return {.pair_by = {},
            .from_label = "sex",
            .from_value = "f",
            .to_label = "sex",
            .to_value = "m",
            .scale = scale};
}

TEST(MeanDifference, OfGroupsWithoutPairsIsThatOfTheirMeans)
{
    for (const Scale scale : {Scale::Unit, Scale::None}) {
        const Collection collection = strangers();
        const ShapeVectors v = shape_vectors(collection, scale);
        const DifferenceVector d = mean_difference(collection, women_to_men(scale));
        const auto women = [](const RowMatrix& m) -> Eigen::VectorXd {
            return (m.row(0) + m.row(2) + m.row(4)).transpose() / 3.0;
        };
        const auto men = [](const RowMatrix& m) -> Eigen::VectorXd {
            return (m.row(1) + m.row(3)).transpose() / 2.0;
        };
        EXPECT_TRUE(d.pairs.empty());
        EXPECT_LE((d.mean_edge_lengths - women(v.edge_lengths)).norm(), 1e-13);
        EXPECT_LE((d.edge_lengths - (men(v.edge_lengths) - women(v.edge_lengths))).norm(), 1e-13);
        EXPECT_LE((d.dihedral_angles - (men(v.dihedral_angles) - women(v.dihedral_angles))).norm(),
                  1e-12);
        EXPECT_NEAR(d.from_size, (v.sizes[0] + v.sizes[2] + v.sizes[4]) / 3.0, 1e-12 * d.from_size);
        EXPECT_NEAR(d.to_size, (v.sizes[1] + v.sizes[3]) / 2.0, 1e-12 * d.to_size);
    }
}

TEST(DifferenceEffects, OfGroupsWithoutPairsAreThoseOfWelchsTest)
{
    const ShapeVectors v = shape_vectors(strangers(), Scale::Unit);
    RowMatrix women(3, v.edge_lengths.cols());
    women << v.edge_lengths.row(0), v.edge_lengths.row(2), v.edge_lengths.row(4);
    RowMatrix men(2, v.edge_lengths.cols());
    men << v.edge_lengths.row(1), v.edge_lengths.row(3);
    const ColumnEffects wanted = independent_effects(women, men);
    const ColumnEffects found = difference_effects(strangers(), women_to_men(Scale::Unit));
    EXPECT_LE((found.effects - wanted.effects).cwiseAbs().maxCoeff(), 1e-9);
    EXPECT_LE((found.probabilities - wanted.probabilities).cwiseAbs().maxCoeff(), 1e-9);
}

TEST(MeanDifference, RefusesGroupsThatAreEmptyOrShareAMesh)
{
    DifferenceOptions options = women_to_men(Scale::Unit);
    options.to_value = "x";
    EXPECT_EQ(message_for(options, strangers()), "difference: no mesh has sex = 'x'");
    Collection collection = strangers();
    collection.labels.push_back({"tall", {"yes", "yes", "no", "no", "no"}});
    options.to_label = "tall";
    options.to_value = "yes";
    EXPECT_NE(message_for(options, collection).find("has both sex = 'f' and tall = 'yes'"),
              std::string::npos);
}

} // namespace
} // namespace shape
