// SPDX-License-Identifier: MIT

#pragma once

#include "libshape/mesh/collection.h"

namespace shape::test {

/// Seeded bumpy spheres of several sizes in several poses, named "sphere00", "sphere01", ...
/// @param count  At most 100.
[[nodiscard]] Collection bumpy_spheres(int count, unsigned seed);

/// The collection in other poses, one seeded rigid motion a mesh.
[[nodiscard]] Collection moved(Collection collection, unsigned seed);

/// All 600 faces of the dataset ict_faces600 with their labels; its folder must exist.
[[nodiscard]] Collection ict_faces();

/// Whether the folder of ict_faces() exists.
[[nodiscard]] bool has_ict_faces();

} // namespace shape::test
