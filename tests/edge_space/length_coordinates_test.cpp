// SPDX-License-Identifier: MIT

#include "libshape/edge_space/length_coordinates.h"

#include <gtest/gtest.h>

#include <cmath>

#include "libshape/base/random.h"

namespace shape {
using namespace internal;
namespace {

constexpr LengthCoordinates all[] = {LengthCoordinates::Plain, LengthCoordinates::Squared,
                                     LengthCoordinates::Log};

Eigen::VectorXd random_lengths(unsigned seed)
{
    Random random(seed);
    Eigen::VectorXd lengths(50);
    for (double& length : lengths)
        length = random.uniform(1e-3, 10.0);
    return lengths;
}

TEST(LengthCoordinates, AreWhatTheirNamesSay)
{
    const Eigen::Vector2d lengths(2.0, 0.5);
    EXPECT_EQ(to_coordinates(LengthCoordinates::Plain, lengths), lengths);
    EXPECT_EQ(to_coordinates(LengthCoordinates::Squared, lengths), Eigen::Vector2d(4.0, 0.25));
    EXPECT_EQ(to_coordinates(LengthCoordinates::Log, lengths),
              Eigen::Vector2d(std::log(2.0), -std::log(2.0)));
}

TEST(LengthCoordinates, GoThereAndBack)
{
    for (const LengthCoordinates kind : all)
        for (unsigned seed = 1; seed <= 10; ++seed) {
            const Eigen::VectorXd lengths = random_lengths(seed);
            const Eigen::VectorXd back = to_lengths(kind, to_coordinates(kind, lengths));
            EXPECT_LE((back - lengths).cwiseQuotient(lengths).cwiseAbs().maxCoeff(), 1e-14);
        }
}

TEST(LengthCoordinates, HaveNoLengthOfANegativeSquare)
{
    EXPECT_EQ(to_lengths(LengthCoordinates::Squared, Eigen::Vector2d(-1.0, 4.0)),
              Eigen::Vector2d(0.0, 2.0));
}

TEST(LengthCoordinates, ChangeWithARelativeChangeByTheirSlope)
{
    constexpr double h = 1e-5;
    for (const LengthCoordinates kind : all) {
        const Eigen::VectorXd lengths = random_lengths(3);
        const Eigen::VectorXd change = (to_coordinates(kind, (1.0 + h) * lengths) -
                                        to_coordinates(kind, (1.0 - h) * lengths)) /
                                       (2.0 * h);
        const Eigen::VectorXd slopes = relative_slopes(kind, lengths);
        EXPECT_LE((change - slopes).cwiseQuotient(slopes).cwiseAbs().maxCoeff(), 1e-9);
    }
}

} // namespace
} // namespace shape
