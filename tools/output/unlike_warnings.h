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

/// Marks meshes that a difference is added to, or that another one was found of; sizes that are divided out may be any.
/// @param meshes, sizes  As of unlike_meshes().
[[nodiscard]] RowMatrix marks_in_transfer(const DifferenceVector& difference,
                                          const Collection& meshes, const Eigen::VectorXd& sizes);

/// How they are spoken of.
[[nodiscard]] UnlikeWords words_of_transfer(const std::string& option, const std::string& others);

/// What is said of meshes that unlike_meshes() has marked: a line for each kind.
/// @param marks  A row for each name.
[[nodiscard]] std::vector<std::string> unlike_warnings(const std::vector<std::string>& names,
                                                       const RowMatrix& marks,
                                                       const UnlikeWords& words);

/// Says that on stderr.
void warn_of_unlike(const Session& session, const std::vector<std::string>& names,
                    const RowMatrix& marks, const UnlikeWords& words);

/// What is said of meshes that far_meshes() has found: a line, or nothing.
/// @param others  "the meshes of model.h5".
[[nodiscard]] std::vector<std::string> far_warnings(const std::vector<std::string>& names,
                                                    const Eigen::VectorXd& times,
                                                    const std::string& others);

/// Says that on stderr.
void warn_of_far(const Session& session, const std::vector<std::string>& names,
                 const Eigen::VectorXd& times, const std::string& others);

} // namespace shape::tools
