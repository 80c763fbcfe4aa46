// SPDX-License-Identifier: MIT

#pragma once

#include <Eigen/Core>
#include <functional>

#include "libshape/edge_space/shape_vectors.h"
#include "libshape/embedding/continuation.h"
#include "libshape/mesh/points.h"
#include "libshape/mesh/topology.h"

namespace shape {

struct PathFollowerOptions
{
    int steps = 16; ///< From s = 0 to 1; >= 1.
    int rounds = 4; ///< Times at most that a mesh is moved on to its lengths; >= 1. It is over
                    ///< once no edge is off by more than
    double edge_tolerance = 2e-3; ///< relative to its length.
    ContinuationOptions continuation;
};

/// A mesh on a path, and the point it was made for: the path's lengths, the follower's angles.
struct PathMesh
{
    ShapePoint target;
    ContinuedMesh mesh;
};

/// Embeds a path of edge lengths whose dihedral angles are known at both ends alone. Blended angles
/// are far from any mesh with the lengths between (a cylinder that narrows to a cone keeps most of
/// its bending, where the blend has lost half of it), and closed meshes are rigid: there the
/// embedding jumps between meshes that fit as badly. So the path is walked in equal steps from the
/// mesh at s = 0. The angles wanted at the next step are those of the last mesh, moved towards the
/// end's by the step's share of what is left; these are so near that they may weigh little, and
/// the lengths are met.
///
/// A mesh between two steps is wanted with the angles blended from both, so it depends on s alone,
/// not on which others are asked for. It changes continuously as long as the meshes do that have
/// the lengths; where they end, it jumps.
class PathFollower
{
public:
    /// @param start  The mesh at s = 0, #V by 3 [length].
    /// @param lengths  #E edge lengths [length] at s in [0, 1]; lengths(0) are those of start.
    /// @param end_angles  #E dihedral angles at s = 1 [rad].
    /// @throws InvalidInput if a size is wrong or an option breaks a rule.
    PathFollower(const Topology& topology, const Points& start,
                 std::function<Eigen::VectorXd(double s)> lengths, Eigen::VectorXd end_angles,
                 const PathFollowerOptions& options = {});

    /// The mesh at s, in the pose of start; start itself at 0. Cheap for ascending s: walks on from where it
    /// was; back to the start for a smaller one.
    /// @throws InvalidInput if s is outside [0, 1], and as continue_to().
    /// Cost: continue_to() once, and once a step walked.
    [[nodiscard]] PathMesh at(double s);

private:
    struct Stop
    {
        Points points;
        Eigen::VectorXd angles; ///< Measured.
    };
    [[nodiscard]] ContinuedMesh reach(const Points& from, ShapePoint target) const;
    [[nodiscard]] Stop next_stop() const;

    Topology topology_;
    std::function<Eigen::VectorXd(double s)> lengths_;
    Eigen::VectorXd end_angles_;
    PathFollowerOptions options_;
    Stop start_;
    int step_ = 0; // s lies between stops step_ and step_ + 1
    Stop here_;
    Stop next_;
};

} // namespace shape
