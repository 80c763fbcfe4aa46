// SPDX-License-Identifier: MIT

#pragma once

#include <Eigen/Core>
#include <memory>

#include "libshape/mesh/points.h"

namespace shape::internal {

/// A piece of surface to shade; the mean of several is one as well.
struct Patch
{
    Eigen::Vector3f place = Eigen::Vector3f::Zero();       ///< View coordinates [length].
    Eigen::Vector3f normal = Eigen::Vector3f::Zero();      ///< As smooth as the surface is to look.
    Eigen::Vector3f flat_normal = Eigen::Vector3f::Zero(); ///< The normal of the face.
    Eigen::Vector3f colour = Eigen::Vector3f::Zero();      ///< Linear RGB.
};

/// The lights of render_mesh() around a mesh, and the shadows that it casts on itself: a shadow map for
/// every light.
class Studio
{
public:
    /// @param points  In view coordinates, not empty.
    Studio(const Faces& faces, const Points& points);
    ~Studio();
    Studio(const Studio&) = delete;
    Studio& operator=(const Studio&) = delete;

    /// The light that a patch sends to the viewer at +z, linear RGB.
    [[nodiscard]] Eigen::Vector3f shade(const Patch& patch) const;

private:
    struct State;
    std::unique_ptr<State> state_;
};

} // namespace shape::internal
