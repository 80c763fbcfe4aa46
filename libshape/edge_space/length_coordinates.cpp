// SPDX-License-Identifier: MIT

#include "libshape/edge_space/length_coordinates.h"

namespace shape {

void internal::to_coordinates(LengthCoordinates coordinates, const Eigen::VectorXd& lengths,
                              Eigen::Ref<Eigen::VectorXd> result)
{
    switch (coordinates) {
        case LengthCoordinates::Squared:
            result = lengths.cwiseAbs2();
            return;
        case LengthCoordinates::Log:
            // Not at once: Eigen's logarithm of several numbers and that of one differ in the last bit, and which a
            // number gets depends on where the result lies in memory.
            result = lengths.array().log().matrix().eval();
            return;
        case LengthCoordinates::Plain:
            result = lengths;
            return;
    }
}

Eigen::VectorXd to_coordinates(LengthCoordinates coordinates, const Eigen::VectorXd& lengths)
{
    Eigen::VectorXd result(lengths.size());
    internal::to_coordinates(coordinates, lengths, result);
    return result;
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
