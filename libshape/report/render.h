// SPDX-License-Identifier: MIT

#pragma once

#include <Eigen/Core>
#include <vector>

#include "libshape/mesh/points.h"
#include "libshape/report/image.h"

namespace shape {

/// Where the viewer stands. Azimuth 0, elevation 0 looks from +z, azimuth 90 from +x, elevation 90
/// from +y.
struct ViewDirection
{
    double azimuth = 0.0;   ///< [deg]
    double elevation = 0.0; ///< [deg] in [-90, 90].
};

/// The rotation to view coordinates: x right, y up (+y of the mesh as far as possible), z towards
/// the viewer.
[[nodiscard]] Eigen::Matrix3d view_rotation(const ViewDirection& direction);

/// The rotation to a view along the direction in which the mesh is thinnest, from the side that
/// most of the surface faces (+z, +y or +x if it faces both alike). A direction within 25 degrees
/// of a coordinate axis becomes that axis.
[[nodiscard]] Eigen::Matrix3d automatic_view(const Faces& faces, const Points& points);

struct RenderOptions
{
    int width = 320;  ///< [pixel], > 0.
    int height = 320; ///< [pixel], > 0.
    Eigen::Vector2d centre =
        Eigen::Vector2d::Zero(); ///< Of the image, in view coordinates [length].
    double pixel_size = 0.01;    ///< [length], > 0.
    double crease_angle = 100.0; ///< Edges that bend more are drawn sharp [deg].
    Colour background{255, 255, 255};
    Colour surface{214, 198, 184};      ///< Used where vertex_colours is empty.
    std::vector<Colour> vertex_colours; ///< Empty, or one per vertex.
};

/// Draws a mesh in parallel projection under studio light: a large light from the upper left, a
/// dome around the object, a narrow light from behind; all of them cast soft shadows. The backs of
/// faces are darker.
///
/// @param points  In view coordinates (see view_rotation).
/// @throws InvalidInput if an option is out of its range or vertex_colours has another size.
/// Cost: about 50 rasterisations of the mesh and 9 samples a pixel; at most 100 MB beside the image.
/// Determinism: pure function.
[[nodiscard]] Image render_mesh(const Faces& faces, const Points& points,
                                const RenderOptions& options);

} // namespace shape
