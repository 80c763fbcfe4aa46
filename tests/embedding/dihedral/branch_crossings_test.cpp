// SPDX-License-Identifier: MIT

#include "libshape/embedding/dihedral/branch_crossings.h"

#include <gtest/gtest.h>

#include "libshape/base/to_size.h"
#include "tests/support/meshes.h"

namespace shape {
using namespace internal;
namespace {

using Eigen::VectorXd;

constexpr int places = 31;

/// An edge well inside of an open patch.
int inner_edge(const Topology& topology, int nth)
{
    for (int e = topology.edge_count() / 4;; ++e)
        if (!topology.is_boundary_edge(e) && nth-- == 0)
            return e;
}

struct Branches
{
    std::vector<BranchPlace> first, second;
};

/// Two branches that differ by an angle at given edges; the first costs t there, the second cost - t.
Branches branches(const Topology& topology, const std::vector<int>& edges,
                  const std::vector<double>& costs, double difference)
{
    const int count = topology.edge_count();
    Branches both;
    for (int i = 0; i < places; ++i) {
        const double t = static_cast<double>(i) / (places - 1);
        BranchPlace a{VectorXd::Zero(count), VectorXd::Zero(count)};
        BranchPlace b = a;
        for (std::size_t k = 0; k < edges.size(); ++k) {
            b.angles[edges[k]] = difference;
            a.energies[edges[k]] = t;
            b.energies[edges[k]] = costs[k] - t;
        }
        both.first.push_back(a);
        both.second.push_back(b);
    }
    return both;
}

TEST(BranchCrossings, LieWhereBothBranchesCostTheSame)
{
    const test::TestMesh mesh = test::open_patch(20, 1);
    const std::vector<int> edges{inner_edge(mesh.topology, 0), inner_edge(mesh.topology, 500)};
    const Branches both = branches(mesh.topology, edges, {1.0, 0.8}, 2.0);
    const BranchCrossings found = branch_crossings(mesh.topology, both.first, both.second, 8);
    ASSERT_EQ(found.folds.size(), 2U);
    for (std::size_t k = 0; k < 2; ++k) {
        const int fold = found.fold_of_edge[to_size(edges[k])];
        ASSERT_GE(fold, 0);
        EXPECT_EQ(found.folds[to_size(fold)].edges, std::vector<int>{edges[k]});
        // t = (cost - t), half-way between two of the 31 places or half a place beside it
        EXPECT_NEAR(found.folds[to_size(fold)].centre, (k == 0 ? 0.5 : 0.4) * (places - 1), 0.51);
    }
    double before = 0.0;
    for (std::size_t i = 0; i < to_size(places); ++i) {
        const double share = found.share(edges[0], i);
        EXPECT_GE(share, before);
        before = share;
        const double other = found.share(edges[1], i);
        const bool is_between =
            (share > 0.0 && share < 1.0) || (other > 0.0 && other < 1.0) || share != other;
        EXPECT_EQ(found.is_between(i), is_between) << i;
    }
    EXPECT_EQ(found.share(edges[0], 0), 0.0);
    EXPECT_EQ(before, 1.0);
    EXPECT_FALSE(found.is_between(0));
    EXPECT_FALSE(found.is_between(to_size(places) - 1));
}

TEST(BranchCrossings, LeaveRoomAtTheEnds)
{
    const test::TestMesh mesh = test::open_patch(20, 1);
    const std::vector<int> edges{inner_edge(mesh.topology, 0), inner_edge(mesh.topology, 500)};
    const Branches both = branches(mesh.topology, edges, {-1.0, 3.0}, 2.0);
    for (const int width : {8, places - 2}) {
        const BranchCrossings found =
            branch_crossings(mesh.topology, both.first, both.second, width);
        ASSERT_EQ(found.folds.size(), 2U);
        EXPECT_FALSE(found.is_between(0));
        EXPECT_FALSE(found.is_between(to_size(places) - 1));
    }
}

TEST(BranchCrossings, AreNoneWhereBranchesAgree)
{
    const test::TestMesh mesh = test::open_patch(20, 1);
    // Differences of less than 0.3 rad, and those of a whole turn, are none.
    for (const double difference : {0.29, 6.2}) {
        const Branches both =
            branches(mesh.topology, {inner_edge(mesh.topology, 0)}, {1.0}, difference);
        const BranchCrossings found = branch_crossings(mesh.topology, both.first, both.second, 8);
        EXPECT_TRUE(found.folds.empty());
        EXPECT_EQ(found.centre, 0.5 * (places - 1));
    }
}

} // namespace
} // namespace shape
