// SPDX-License-Identifier: MIT

#pragma once

#include <vector>

#include "libshape/edge_space/shape_space.h"

namespace shape::test {

/// One of every choice that a space has, with and without size.
[[nodiscard]] inline std::vector<SpaceOptions> sample_spaces()
{
    std::vector<SpaceOptions> spaces;
    for (const Scale scale : {Scale::Unit, Scale::None}) {
        spaces.push_back({.kind = SpaceKind::Procrustes, .scale = scale});
        for (const LengthCoordinates coordinates :
             {LengthCoordinates::Plain, LengthCoordinates::Squared, LengthCoordinates::Log})
            for (const EdgeWeighting weighting : {EdgeWeighting::Uniform, EdgeWeighting::Area})
                for (const double weight : {0.0, 0.2})
                    spaces.push_back({.kind = SpaceKind::Edge,
                                      .scale = scale,
                                      .coordinates = coordinates,
                                      .weighting = weighting,
                                      .dihedral_weight = weight});
        spaces.push_back({.scale = scale, .position_weight = 3.0});
        spaces.push_back({.scale = scale,
                          .coordinates = LengthCoordinates::Log,
                          .weighting = EdgeWeighting::Area,
                          .dihedral_weight = 0.2,
                          .position_weight = 3.0});
    }
    return spaces;
}

} // namespace shape::test
