// SPDX-License-Identifier: MIT

#pragma once

#include <string>
#include <vector>

#include "libshape/edge_space/shape_space.h"
#include "libshape/model/unlike_meshes.h"

namespace shape::tools {

class Session;

/// How meshes that are unlike others are spoken of.
struct UnlikeWords
{
    std::string option = {}; ///< Goes before the names: "--onto: ".
    std::string others;      ///< "the meshes of model.h5".
    std::string mirrored;    ///< What comes of mirror images: "edge lengths do not see that".
    std::string size = {};   ///< What comes of other sizes; or nothing in particular.
    bool are_differences =
        false; ///< The names are files of differences that are made of such meshes.
};

/// What comes of a mirror image where shapes are only measured.
[[nodiscard]] std::string effect_of_mirroring(const ShapeSpace& space);

/// Warns, in a line for each kind, of meshes that unlike_meshes() has marked.
/// @param marks  A row for each name.
void warn_of_unlike(const Session& session, const std::vector<std::string>& names,
                    const RowMatrix& marks, const UnlikeWords& words);

/// Warns, in one line, of meshes that far_meshes() has found.
/// @param others  "the meshes of model.h5".
void warn_of_far(const Session& session, const std::vector<std::string>& names,
                 const Eigen::VectorXd& times, const std::string& others);

} // namespace shape::tools
