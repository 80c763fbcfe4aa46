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
/// @throws InvalidInput if the mesh is as render_mesh() refuses it.
[[nodiscard]] Eigen::Matrix3d automatic_view(const Faces& faces, const Points& points);

struct RenderOptions
{
    /// The image is this wide [pixel]; in [1, 32768].
    int width = 320;
    /// The image is this high [pixel]; in [1, 32768].
    int height = 320;
    /// The image shows this point, in view coordinates, in its middle [length]; finite.
    Eigen::Vector2d centre = Eigen::Vector2d::Zero();
    /// A pixel is this wide and high [length]; > 0.
    double pixel_size = 0.01;
    /// Edges that bend more are drawn sharp [deg]; >= 0.
    double crease_angle = 100.0;
    /// What is not covered has this colour.
    Colour background{255, 255, 255};
    /// The mesh has this colour where vertex_colours is empty.
    Colour surface{214, 198, 184};
    /// Every vertex has its colour; empty, or one per vertex.
    std::vector<Colour> vertex_colours = {};
};

/// @throws InvalidInput naming the first field that breaks its rule.
void check(const RenderOptions& options);

/// Draws a mesh in parallel projection under studio light: a large light from the upper left, a
/// dome around the object, a narrow light from behind; all of them cast soft shadows. The backs of
/// faces are darker.
///
/// @param points  In view coordinates (see view_rotation).
/// @throws InvalidInput if an option breaks its rule, vertex_colours has another size, the mesh has no
///     vertex or a coordinate that is not finite, or a face names a vertex that there is not.
/// Cost: about 50 rasterisations of the mesh and 9 samples a pixel; at most 100 MB beside the image.
/// Determinism: pure function.
[[nodiscard]] Image render_mesh(const Faces& faces, const Points& points,
                                const RenderOptions& options);

} // namespace shape
