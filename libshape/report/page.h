// SPDX-License-Identifier: MIT

#pragma once

#include <string>
#include <utility>
#include <vector>

#include "libshape/mesh/points.h"
#include "libshape/mesh/topology.h"

namespace shape {

/// Shapes of one mesh along a parameter, for the viewer of a page.
struct ShapeTrack
{
    std::string name;
    std::vector<Points> shapes; ///< One or more, evenly spaced from low to high.
    double low = 0.0;
    double high = 1.0; ///< >= low.
};

/// What stands on a page, in this order but for the viewer, which follows the facts.
struct Page
{
    std::string title;
    std::vector<std::pair<std::string, std::string>> facts; ///< Name and value.
    Faces faces;
    std::vector<ShapeTrack> tracks;    ///< What the viewer offers; none: there is no viewer.
    std::string unit;                  ///< Of the tracks' parameter.
    std::vector<std::string> drawings; ///< SVG documents.
    std::vector<std::vector<std::string>> table; ///< The first row is its head; may be empty.
};

/// The page as one HTML document that needs no other file and no network. Its viewer draws with
/// WebGL 2; shapes between two of a track are linear blends of theirs, in single precision.
/// @throws InvalidInput if a track has no shape, one with another number of vertices or one that is
///     not finite.
[[nodiscard]] std::string page_html(const Page& page);

} // namespace shape
