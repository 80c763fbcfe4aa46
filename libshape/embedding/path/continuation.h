// SPDX-License-Identifier: MIT

#pragma once

#include <Eigen/Core>
#include <memory>

#include "libshape/edge_space/shape_vectors.h"
#include "libshape/mesh/points.h"
#include "libshape/mesh/topology.h"

namespace shape {

struct ContinuationOptions
{
    /// Angles weigh this much against lengths: mu of docs/embedding.md; > 0.
    double smoothness = 1e-4;
    /// Edges are stiffer by up to 9 times from strains of 6 % / stiffness on; > 0.
    double stiffness = 1.0;
    /// A mesh has converged once a step lowers E by <= decrease_tolerance * E; >= 0.
    double decrease_tolerance = 1e-2;
    /// A mesh takes at most this many Gauss-Newton steps; >= 0.
    int max_iterations = 12;
};

/// @throws InvalidInput naming the first field that breaks its rule.
void check(const ContinuationOptions& options);

struct SettlingOptions
{
    /// The angles that a mesh has weigh this much against lengths in the first round; > 0. Less, by 0.3 each
    /// time, after rounds whose step could be taken in full.
    double smoothness = 1e-3;
    /// Edges are this stiff, as in ContinuationOptions; > 0.
    double stiffness = 12.0;
    /// Lengths are met where |l - l*| <= edge_tolerance * l* on every edge; >= 0.
    double edge_tolerance = 4e-3;
    /// At most this many rounds; >= 0.
    int rounds = 24;
};

/// @throws InvalidInput naming the first field that breaks its rule.
void check(const SettlingOptions& options);

struct ContinuedMesh
{
    Points points;       ///< #V by 3 [length], in the pose of the mesh before.
    double energy = 0.0; ///< E of docs/embedding.md.
    int iterations = 0;  ///< Gauss-Newton steps.
    bool converged =
        false; ///< A step met decrease_tolerance, or none lowers E; settle(): lengths are met.
};

/// Moves meshes of one topology to targets nearby, as in a sequence. Edge lengths may range over
/// ten orders of magnitude (fine regions also move as wholes). The patterns of the two factors are analysed once.
///
/// Sizes, targets and options that break a rule throw InvalidInput.
class Continuation
{
public:
    /// @param lengths  #E [length], > 0: about those of the targets. Where these are finer in places,
    ///     lengths should be.
    Continuation(const Topology& topology, const Eigen::VectorXd& lengths);
    ~Continuation();
    Continuation(Continuation&&) noexcept;
    Continuation& operator=(Continuation&&) noexcept;

    /// To another target: the faces give the frames, which the target's lengths and angles refine
    /// by turning every face to its best fit; then as adjust().
    /// @param from  #V by 3 [length], without degenerate faces.
    /// Cost: a sparse Cholesky factorisation of size #V, and adjust().
    [[nodiscard]] ContinuedMesh move(const Points& from, const ShapePoint& target,
                                     const ContinuationOptions& options = {});

    /// From a mesh that all but fits: Gauss-Newton steps.
    /// Cost: a sparse Cholesky factorisation of size 3 #V a step.
    [[nodiscard]] ContinuedMesh adjust(const Points& from, const ShapePoint& target,
                                       const ContinuationOptions& options = {});

    /// Meets lengths, bending a mesh as little as that takes. A round is one Gauss-Newton step that wants
    /// the angles which the mesh then has: so the weight of these damps the step (Levenberg), and small
    /// bends that are of no use are not made. Where only few edges are off, the regions around them
    /// are moved, larger in each such round, and the rest of the mesh is held.
    /// @param lengths  #E [length], > 0.
    /// Cost: a sparse Cholesky factorisation of size 3 #V a round, or of the regions.
    [[nodiscard]] ContinuedMesh settle(const Points& from, const Eigen::VectorXd& lengths,
                                       const SettlingOptions& options = {});

private:
    struct State;
    std::unique_ptr<State> state_;
};

} // namespace shape
