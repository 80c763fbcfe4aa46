// SPDX-License-Identifier: MIT

#pragma once

#include <cstddef>
#include <filesystem>
#include <vector>

#include "libshape/mesh/points.h"

namespace shape {

struct GlbAnimationOptions
{
    /// Frames are left out while positions between the others stay within this times the bounding box
    /// diagonal [1]; >= 0.
    double tolerance = 1e-3;
    /// The animation shows this many frames a second; in [1e-6, 1e6].
    double frames_per_second = 25.0;
};

/// @throws InvalidInput naming the first field that breaks its rule.
void check(const GlbAnimationOptions& options);

/// What a viewer shows.
struct GlbAnimation
{
    std::vector<std::size_t> keyframes; ///< Frames that are in the file; those between are blends.
    double error = 0.0;   ///< Largest error of a coordinate of any frame / diagonal of
                          ///< the bounding box of the first [1].
    double seconds = 0.0; ///< From the first frame to the last.
};

/// Writes a sequence of meshes as one binary glTF 2.0 file (GLB) that any viewer plays: the first
/// frame and one morph target for each further keyframe, whose weights run linearly from one
/// keyframe to the next. The keyframes are the fewest of choose_keyframes().
///
/// glTF is single precision: positions are stored relative to the centre of the first frame's
/// bounding box, where the node puts them. Normals are those of smooth shading, area-weighted means
/// over the faces at a vertex, and are morphed alike. The material shows both sides of the faces if
/// the mesh has a boundary. The file appears whole or not at all: it is written beside, synced and renamed.
///
/// @param frames  At least two of one size.
/// @throws InvalidInput if a rule is broken, a coordinate is not finite or beyond single precision,
///     or a face names a missing vertex.
/// @throws LimitExceeded if the file would have 4 GiB or more; FileError if it cannot be written.
/// Cost: that of choose_keyframes(); 24 bytes a vertex and keyframe in memory and in the file.
GlbAnimation write_glb_animation(const std::filesystem::path& path,
                                 const std::vector<Points>& frames, const Faces& faces,
                                 const GlbAnimationOptions& options = {});

} // namespace shape
