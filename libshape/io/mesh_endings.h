// SPDX-License-Identifier: MIT

#pragma once

#include <string>
#include <string_view>

#include "libshape/base/letter_case.h"

namespace shape::internal {

/// The name of a mesh without the ending of its file (.ply, .stl, ..., in any case), which tables often
/// keep.
[[nodiscard]] inline std::string_view without_mesh_ending(std::string_view name)
{
    const std::string lower = lower_case(name);
    for (const std::string_view ending : {".ply", ".obj", ".off", ".stl", ".vtk", ".vtp", ".glb"})
        if (lower.size() > ending.size() && lower.ends_with(ending)) {
            name.remove_suffix(ending.size());
            break;
        }
    return name;
}

} // namespace shape::internal
