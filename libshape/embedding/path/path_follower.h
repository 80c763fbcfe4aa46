// SPDX-License-Identifier: MIT

#pragma once

#include <Eigen/Core>
#include <functional>

#include "libshape/edge_space/shape_vectors.h"
#include "libshape/embedding/path/continuation.h"
#include "libshape/mesh/points.h"
#include "libshape/mesh/topology.h"

namespace shape {

struct PathFollowerOptions
{
    /// The path is walked in this many equal steps from s = 0 to 1; >= 1.
    int steps = 16;
    /// Angles wanted at a step are moved towards those of the end by this times the step's share of
    /// what is left, at most all the way; > 0.
    double angle_gain = 6.0;
    /// Those angles weigh this much against lengths: mu of docs/embedding.md; > 0.
    double guidance = 1e-2;
    /// The angles that resulted weigh this much when the lengths are met, at first, and between steps; > 0.
    double smoothness = 1e-3;
    /// Edges are this stiff then (continuation.h); > 0.
    double stiffness = 12.0;
    /// Lengths are met in at most this many rounds of Continuation::settle(); >= 0.
    int rounds = 24;
    /// Lengths are met where |l - l*| <= edge_tolerance * l* on every edge; >= 0.
    double edge_tolerance = 4e-3;
};

/// @throws InvalidInput naming the first field that breaks its rule.
void check(const PathFollowerOptions& options);

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
/// mesh at s = 0. Each step moves the last mesh to the next lengths, guided by its angles moved
/// towards the end's; then the angles wanted are those that resulted, which may weigh little, and
/// the lengths are met.
///
/// Equal lengths do not make equal meshes: without guidance, dents that the end does not have
/// stay to the end. With it, they turn over one by one while they are shallow, and the path ends at
/// the mesh that has both the lengths and the angles of the end.
///
/// A mesh between two steps is wanted with the angles blended from both, so it depends on s alone,
/// not on which others are asked for.
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
    /// @throws InvalidInput if s is outside [0, 1].
    /// Cost: of a mesh, for itself and for each step walked: Continuation::move() and settle().
    [[nodiscard]] PathMesh at(double s);

private:
    struct Stop
    {
        Points points;
        Eigen::VectorXd angles; ///< Measured.
    };
    [[nodiscard]] ContinuedMesh settle(const ContinuedMesh& mesh, const Eigen::VectorXd& lengths);
    [[nodiscard]] Stop next_stop();

    Topology topology_;
    std::function<Eigen::VectorXd(double s)> lengths_;
    Eigen::VectorXd end_angles_;
    PathFollowerOptions options_;
    Continuation continuation_;
    Stop start_;
    int step_ = 0; // s lies between stops step_ and step_ + 1
    Stop here_;
    Stop next_;
};

} // namespace shape
