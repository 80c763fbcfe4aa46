// SPDX-License-Identifier: MIT

#include "libshape/mesh/oddities.h"

#include <gtest/gtest.h>

#include <cmath>

#include "libshape/base/format.h"
#include "tests/support/seams.h"

namespace shape {
using namespace internal;
namespace {

using Indices = std::vector<std::size_t>;
using test::TestMesh;

/// What a program offers it says itself.
void expect_no_command(const std::vector<Oddity>& oddities)
{
    for (const Oddity& oddity : oddities)
        EXPECT_EQ(oddity.message.find_first_of("`"), std::string::npos) << oddity.message;
}

/// Seven bumpy spheres, a to g.
Collection spheres()
{
    const TestMesh first = test::bumpy_sphere(2, 0.1, 0);
    Collection collection{first.topology, {}, {}, {}};
    for (unsigned i = 0; i < 7; ++i) {
        collection.names.push_back(std::string(1, static_cast<char>('a' + i)));
        collection.points.push_back(test::bumpy_sphere(2, 0.1, i).points);
    }
    return collection;
}

TEST(Oddities, SoundCollectionsHaveNone)
{
    EXPECT_TRUE(find_oddities(spheres()).empty());
    for (const TestMesh& mesh : test::sample_meshes()) {
        const Collection alone{mesh.topology, {"a"}, {mesh.points}, {}};
        for (const Oddity& oddity : find_oddities(alone))
            ADD_FAILURE() << mesh.name << ": " << oddity.message;
    }
}

TEST(Oddities, ASeamIsCountedWithAPlaceAndAWayOut)
{
    const TestMesh sphere = test::bumpy_sphere(2, 0.1, 0);
    const test::CutMesh cut = test::cut_along_the_equator(sphere);
    Collection collection = spheres();
    collection.topology = Topology(cut.faces, static_cast<int>(cut.vertices.size()));
    for (Points& points : collection.points)
        points = cut.points(points);
    const std::vector<Oddity> found = find_oddities(collection);
    ASSERT_EQ(found.size(), 1U);
    EXPECT_EQ(found[0].kind, OddityKind::Seam);
    EXPECT_EQ(found[0].meshes.size(), 7U);
    const int places = cut.doubled(sphere.points);
    EXPECT_TRUE(found[0].message.starts_with(
        join(2 * places, " boundary vertices lie on one another at ", places, " places")))
        << found[0].message;
    EXPECT_TRUE(found[0].message.ends_with("or weld them")) << found[0].message;
    expect_no_command(found);
    // What is a little apart is near.
    std::vector<Points> closed = collection.points;
    for (Points& points : collection.points)
        points.bottomRows(places).col(0).array() += 1e-6 * bounding_box_diagonal(points);
    const std::vector<Oddity> near = find_oddities(collection);
    ASSERT_EQ(near.size(), 1U);
    EXPECT_EQ(near[0].kind, OddityKind::NearSeam);
    EXPECT_EQ(near[0].meshes.size(), 7U);
    EXPECT_TRUE(near[0].message.starts_with(
        join(2 * places,
             " boundary vertices lie near one another, up to 1e-06 of the diagonal "
             "apart, at ",
             places, " places in all meshes, first a: vertices ")))
        << near[0].message;
    expect_no_command(near);
    collection.points = closed;
    // What is apart in one mesh is not a seam.
    collection.points[3].bottomRows(places) *= 1.01;
    EXPECT_TRUE(find_oddities(collection).empty());
}

TEST(Oddities, MirrorImagesAndTurnedSurfacesAreNamed)
{
    Collection collection = spheres();
    collection.points[1] = test::mirror_image(collection.points[1]);
    collection.points[4] = test::mirror_image(collection.points[4]);
    std::vector<Oddity> found = find_oddities(collection);
    ASSERT_EQ(found.size(), 1U);
    EXPECT_EQ(found[0].kind, OddityKind::Mirrored);
    EXPECT_EQ(found[0].meshes, (Indices{1, 4}));
    EXPECT_TRUE(found[0].message.starts_with("b and e are mirror images of the other 5 meshes"))
        << found[0].message;
    for (Points& points : collection.points)
        points = test::mirror_image(points);
    found = find_oddities(collection);
    ASSERT_EQ(found.size(), 2U);
    EXPECT_EQ(found[1].kind, OddityKind::InsideOut);
    EXPECT_EQ(found[1].meshes, (Indices{0, 2, 3, 5, 6}));
    EXPECT_NE(found[1].message.find("inside out"), std::string::npos);
    expect_no_command(found);
}

TEST(Oddities, SheetsThatBendTheOtherWayAreNoMirrorImages)
{
    const TestMesh sheet = test::open_patch(8, 1);
    Collection collection{sheet.topology, {}, {}, {}};
    for (const double curl : {.1, .16, .06, .14, .09, -.09}) {
        collection.names.push_back(std::string(1, static_cast<char>('a' + collection.size())));
        collection.points.push_back(sheet.points);
        collection.points.back().col(2) = curl * sheet.points.col(0).cwiseAbs2();
    }
    const std::vector<Oddity> found = find_oddities(collection);
    ASSERT_EQ(found.size(), 1U);
    EXPECT_EQ(found[0].kind, OddityKind::Bent);
    EXPECT_EQ(found[0].meshes, Indices{5});
    EXPECT_TRUE(found[0].message.starts_with(
        "f bends the other way than the other 5 meshes, or is a mirror image of them, which such "
        "sheets do not tell; mirror it back"))
        << found[0].message;
}

TEST(Oddities, SizesOfOtherUnitsAreNamed)
{
    Collection collection = spheres();
    collection.points[6] *= 1000.0;
    const std::vector<Oddity> found = find_oddities(collection);
    ASSERT_EQ(found.size(), 1U);
    EXPECT_EQ(found[0].kind, OddityKind::Size);
    EXPECT_EQ(found[0].meshes, Indices{6});
    EXPECT_NE(found[0].message.find("g is "), std::string::npos) << found[0].message;
    EXPECT_NE(found[0].message.find("millimetres and metres"), std::string::npos);
    expect_no_command(found);
}

TEST(Oddities, SizesOfEachUnitAreNamedByThemselves)
{
    Collection collection = spheres();
    collection.points[1] *= 10.0;
    collection.points[4] *= 10.0;
    collection.points[2] *= 1000.0;
    const std::vector<Oddity> found = find_oddities(collection);
    ASSERT_EQ(found.size(), 1U);
    EXPECT_EQ(found[0].meshes, (Indices{1, 2, 4}));
    for (const char* part :
         {": b and e are ", " times larger (millimetres and centimetres?), c is ",
          " times larger (millimetres and metres?) than the other 4 meshes; "})
        EXPECT_NE(found[0].message.find(part), std::string::npos) << found[0].message;
    const std::vector<double> sizes{1.0, 10.0, 0.1, 1.1, 11.0, 1e3, 0.9, 0.11, 1e-3};
    const std::vector<std::size_t> odd = odd_sizes(sizes);
    EXPECT_EQ(odd, (Indices{1, 2, 4, 5, 7, 8}));
    EXPECT_EQ(parts_of_odd_sizes(sizes, odd), (std::vector<Indices>{{8}, {2, 7}, {1, 4}, {5}}));
    // Of one gap each, on either side of the rest.
    EXPECT_EQ(parts_of_odd_sizes({0.8, 1.0, 1.1, 1.2}, {0, 3}), (std::vector<Indices>{{0}, {3}}));
}

TEST(Oddities, CopiesAreNamedWithWhatTheyDifferBy)
{
    Collection collection = spheres();
    collection.points[6] = collection.points[1];
    std::vector<Oddity> found = find_oddities(collection);
    ASSERT_EQ(found.size(), 1U);
    EXPECT_EQ(found[0].kind, OddityKind::Copies);
    EXPECT_EQ(found[0].meshes, Indices{6});
    EXPECT_EQ(found[0].message,
              "b and g are copies of one mesh, in place or moved; statistics count "
              "each of them: keep one");
    for (double& x : collection.points[6].reshaped())
        x = 1e-4 * std::round(1e4 * x);
    found = find_oddities(collection);
    ASSERT_EQ(found.size(), 1U);
    EXPECT_NE(found[0].message.find("in place or moved, up to 2"), std::string::npos)
        << found[0].message;
    EXPECT_NE(found[0].message.find("e-05 of the diagonal apart, as rounding leaves them;"),
              std::string::npos)
        << found[0].message;
}

TEST(Oddities, OddSizesStandApartFromTheLargestPart)
{
    EXPECT_EQ(odd_sizes({1.0, 1.2, 0.9}), Indices{});
    EXPECT_EQ(odd_sizes({1.0, 4.9}), Indices{});
    EXPECT_EQ(odd_sizes({5.1, 1.0}), Indices{0}); // the smaller ones stand first
    EXPECT_EQ(odd_sizes({1.0, 1e3, 1.1e3, 0.9e3}), Indices{0});
    EXPECT_EQ(odd_sizes({1.0, 2.0, 4.0, 8.0, 16.0, 32.0}), Indices{}); // a steady growth
    EXPECT_EQ(odd_sizes({7.7, 0.008, 7.5, 0.0081, 7.9}), (Indices{1, 3}));
    EXPECT_EQ(odd_sizes({1.0, 1.01, 0.99, 2.54, 1.02, 0.98}), Indices{3});         // inches
    EXPECT_EQ(odd_sizes({1.0, 2.56, 1.01, 2.54, 0.99, 2.52}), (Indices{1, 3, 5})); // half of them
    EXPECT_EQ(odd_sizes({1.0, 2.86, 1.01, 2.84, 0.99, 2.82}), (Indices{1, 3, 5})); // whatever it is
    EXPECT_EQ(odd_sizes({1.0, 2.26, 1.01, 2.24, 0.99, 2.28}), Indices{});          // two kinds
    EXPECT_EQ(odd_sizes({1.0, 1.01, 0.99, 1.5, 1.02, 0.98}), Indices{});
    EXPECT_EQ(odd_sizes({1.0, 1.4, 0.7, 2.9, 1.2, 0.8}), Indices{}); // a wide spread
    EXPECT_EQ(odd_sizes({}), Indices{});
}

TEST(Oddities, InchesAreToldFromSizesThatVary)
{
    // Eight vertebrae of adults, 6.5 % of standard deviation, as they are and three of them in inches.
    const std::vector<double> bones{26.66, 24.92, 27.31, 29.23, 25.40, 28.12, 23.81, 26.05};
    EXPECT_EQ(odd_sizes(bones), Indices{});
    std::vector<double> mixed = bones;
    for (const std::size_t i : {0U, 4U, 5U})
        mixed[i] /= 2.54;
    EXPECT_EQ(odd_sizes(mixed), (Indices{0, 4, 5}));
    mixed[3] /= 2.54; // the first of equal parts, the smaller ones, counts as usual
    EXPECT_EQ(odd_sizes(mixed), (Indices{1, 2, 6, 7}));
    // Children and adults, smoothly and in two kinds; a ratio near 2.54 of sizes that spread widely.
    EXPECT_EQ(odd_sizes({10.0, 11.2, 13.1, 14.0, 16.2, 18.1, 20.5, 24.0, 25.4, 26.1}), Indices{});
    for (const double ratio : {1.6, 1.8, 2.0}) {
        std::vector<double> kinds = bones;
        for (const std::size_t i : {1U, 4U, 6U, 7U})
            kinds[i] /= ratio;
        EXPECT_EQ(odd_sizes(kinds), Indices{}) << ratio;
    }
    EXPECT_EQ(odd_sizes({1.0, 1.3, 0.8, 1.1, 2.54, 2.9, 2.2, 3.1}), Indices{});
    for (const double ratio : {2.83, 1.0 / 0.3048, 4.0, 4.5}) {
        std::vector<double> parts = bones;
        for (const std::size_t i : {1U, 4U, 6U})
            parts[i] /= ratio;
        EXPECT_EQ(odd_sizes(parts), (Indices{1, 4, 6})) << ratio;
    }
}

TEST(Oddities, AHundredThousandSizesAreSortedOutAtOnce)
{
    std::vector<double> sizes; // in time that is quadratic: minutes
    for (int i = 0; i < 100'000; ++i)
        sizes.push_back(1.0 + 1e-6 * i);
    EXPECT_EQ(odd_sizes(sizes), Indices{});
    sizes[3] *= 3.2808;
    sizes[7] *= 3.2808;
    EXPECT_EQ(odd_sizes(sizes), (Indices{3, 7}));
}

TEST(Oddities, LongListsOfNamesAreCutShort)
{
    std::vector<std::string> names;
    Indices all;
    for (std::size_t i = 0; i < 12; ++i) {
        names.push_back(join("m", i));
        all.push_back(i);
    }
    EXPECT_EQ(list_names(names, {3}), "m3");
    EXPECT_EQ(list_names(names, {0, 2, 5}), "m0, m2 and m5");
    EXPECT_EQ(list_names(names, all), "m0, m1, m2, m3, m4, m5, m6 and 5 more");
    EXPECT_EQ(list_names(names), list_names(names, all));
}

TEST(Oddities, OneOfTwoIsComparedWithTheOtherMesh)
{
    Collection two = subset(spheres(), {0, 1});
    two.points[1] = 25.4 * test::mirror_image(two.points[1]);
    const std::vector<Oddity> found = find_oddities(two);
    ASSERT_EQ(found.size(), 2U);
    EXPECT_NE(found[0].message.find("of the other mesh ("), std::string::npos) << found[0].message;
    EXPECT_NE(found[1].message.find("than the other mesh;"), std::string::npos) << found[1].message;
}

TEST(Oddities, StretchedMeshesAreNamedWithAxisAndFactor)
{
    Collection collection = spheres();
    collection.points[3].col(1) *= 0.5;
    std::vector<Oddity> found = find_oddities(collection);
    ASSERT_EQ(found.size(), 1U);
    EXPECT_EQ(found[0].kind, OddityKind::Stretched);
    EXPECT_EQ(found[0].meshes, Indices{3});
    EXPECT_TRUE(found[0].message.starts_with("d is ")) << found[0].message;
    EXPECT_NE(found[0].message.find(" times shorter along y than the other 6 meshes"),
              std::string::npos)
        << found[0].message;
    for (const std::size_t i : {3U, 5U})
        collection.points[i] = test::moved(collection.points[i], 4);
    collection.points[5] = collection.points[3];
    collection.points[5].row(0) *= 1.01; // no copy
    found = find_oddities(collection);
    ASSERT_EQ(found.size(), 1U);
    EXPECT_NE(found[0].message.find("shorter along one axis of theirs than the other 5 meshes"),
              std::string::npos)
        << found[0].message;
    expect_no_command(found);
}

TEST(Oddities, CoarseCoordinatesAreNamedWithTheirStepAndCause)
{
    Collection collection = spheres();
    for (const std::size_t i : {2U, 5U})
        collection.points[i] = (collection.points[i].rowwise() + Eigen::RowVector3d(0.0, 8e5, 0.0))
                                   .cast<float>()
                                   .cast<double>();
    const std::vector<Oddity> found = find_oddities(collection);
    ASSERT_EQ(found.size(), 1U);
    EXPECT_EQ(found[0].kind, OddityKind::Coarse);
    EXPECT_EQ(found[0].meshes, (Indices{2, 5}));
    EXPECT_TRUE(found[0].message.starts_with("c and f: coordinates are, in ")) << found[0].message;
    EXPECT_NE(found[0].message.find("multiples of 0.0625, "), std::string::npos)
        << found[0].message;
    EXPECT_NE(found[0].message.find("single precision"), std::string::npos);
    EXPECT_NE(found[0].message.find("local origin"), std::string::npos);
    expect_no_command(found);
}

} // namespace
} // namespace shape
