// SPDX-License-Identifier: MIT

#include "libshape/edge_space/length_coordinates.h"

namespace shape {

Eigen::VectorXd to_coordinates(LengthCoordinates coordinates, const Eigen::VectorXd& lengths)
{
    switch (coordinates) {
        case LengthCoordinates::Squared:
            return lengths.cwiseAbs2();
        case LengthCoordinates::Log:
            return lengths.array().log();
        case LengthCoordinates::Plain:
            break;
    }
    return lengths;
}

Eigen::VectorXd to_lengths(LengthCoordinates coordinates, const Eigen::VectorXd& values)
{
    switch (coordinates) {
        case LengthCoordinates::Squared:
            return values.cwiseMax(0.0).cwiseSqrt();
        case LengthCoordinates::Log:
            return values.array().exp();
        case LengthCoordinates::Plain:
            break;
    }
    return values;
}

Eigen::VectorXd relative_slopes(LengthCoordinates coordinates, const Eigen::VectorXd& lengths)
{
    switch (coordinates) {
        case LengthCoordinates::Squared:
            return 2.0 * lengths.cwiseAbs2();
        case LengthCoordinates::Log:
            return Eigen::VectorXd::Ones(lengths.size());
        case LengthCoordinates::Plain:
            break;
    }
    return lengths;
}

} // namespace shape
