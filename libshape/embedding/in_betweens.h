// SPDX-License-Identifier: MIT

#pragma once

#include <optional>
#include <vector>

#include "libshape/embedding/embedder.h"

namespace shape {

/// A mesh of a sequence that the meshes between are made from (Rojas 2014, sections 3 and 6).
struct Keyframe
{
    double time = 0.0; ///< Place in the sequence, any unit.
    ShapePoint target; ///< What it was embedded from.
    Points points;     ///< #V by 3 [length], placed as it is to appear.
};

/// How vertices move where no embedding method fills in.
enum class KeyframeMotion
{
    Linear, ///< Straight from keyframe to keyframe, with kinks there.
    Spline, ///< Along catmull_rom_weights() through all keyframes.
};

/// Makes the meshes between keyframes.
class InBetweens
{
public:
    /// Fills in by another embedding method.
    ///
    /// A keyframe differs from its target in lengths and angles. These differences are added to the
    /// targets around it, fading from one keyframe to the next with level ends. So the target at a
    /// keyframe is that of a mesh, which every method gives back, and none jumps or bends
    /// there. Where a corrected target breaks a triangle inequality, though the target itself keeps all, the
    /// mesh nearest to it comes out (Embedder::embed()). Each result is turned and placed between its best fits to the two keyframes.
    /// @param references  As Embedder takes them.
    /// @throws InvalidInput if there are fewer than two keyframes, their times do not increase or a
    ///     size does not fit; or as Embedder does.
    InBetweens(const Topology& topology, std::vector<Keyframe> keyframes,
               std::vector<Points> references, const EmbeddingOptions& filler);

    /// Moves the vertices from keyframe to keyframe.
    /// @throws InvalidInput as above.
    InBetweens(const Topology& topology, std::vector<Keyframe> keyframes, KeyframeMotion motion);

    /// The mesh at a time; at that of a keyframe its points, to the bit.
    /// @param time  Within that of the first and the last keyframe.
    /// @param target  What is wanted at this time; the report measures against it.
    /// @throws InvalidInput if time is out of its range; else as Embedder::embed().
    [[nodiscard]] Embedding embed(double time, const ShapePoint& target) const;

private:
    [[nodiscard]] Embedding fill(std::size_t before, double time, const ShapePoint& target) const;
    [[nodiscard]] Points move(std::size_t before, double time) const;

    Topology topology_;
    std::vector<Keyframe> keyframes_;
    std::vector<ShapePoint> differences_; ///< Keyframe minus its target; angles in (-pi, pi].
    std::optional<Embedder> filler_;
    KeyframeMotion motion_ = KeyframeMotion::Linear;
};

} // namespace shape
