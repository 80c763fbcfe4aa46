// SPDX-License-Identifier: MIT

#include "libshape/embedding/multiscale/multiscale_embedding.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>
#include <mutex>
#include <span>

#include "libshape/base/error.h"
#include "libshape/base/format.h"
#include "libshape/base/pool.h"
#include "libshape/base/require.h"
#include "libshape/base/threads.h"
#include "libshape/base/to_size.h"
#include "libshape/edge_space/angle_limit.h"
#include "libshape/embedding/multiscale/multiscale_hierarchy.h"
#include "libshape/embedding/multiscale/patch_registration.h"
#include "libshape/linalg/packed_cholesky.h"
#include "libshape/linalg/sparse_cholesky.h"

namespace shape {
using namespace internal;
namespace {

constexpr int supernodal_vertices = 10000; // larger systems go to CHOLMOD

using Clock = std::chrono::steady_clock;

/// Adds the time since the last call to the given sum.
class Stopwatch
{
public:
    void add_to(double& seconds)
    {
        const Clock::time_point now = Clock::now();
        seconds += std::chrono::duration<double>(now - last_).count();
        last_ = now;
    }

private:
    Clock::time_point last_ = Clock::now();
};

/// What the patches are made from.
struct Target
{
    std::span<const double> lengths;
    std::vector<Eigen::Vector2d> bends; ///< Cosine and sine of the dihedral angles.
};

/// Positions of a run of patches and, beside them, the right-hand sides of condition (3): at each
/// vertex the sum of the patch's edge vectors that end there, in their wanted lengths.
struct Workspace
{
    std::size_t begin = 0; ///< Row of the hierarchy's vertices that entry 0 belongs to.
    std::vector<PaddedPoint> positions;
    std::vector<Eigen::Vector4d> divergence;

    void cover(std::size_t first, std::size_t end)
    {
        begin = first;
        if (positions.size() < end - first) {
            positions.resize(end - first);
            divergence.resize(end - first);
        }
    }
};

/// Of a leaf's first triangle in the reference: directions of its first edge and of the height over
/// that.
struct LeafFrame
{
    Eigen::Vector3d edge = Eigen::Vector3d::UnitX();
    Eigen::Vector3d height = Eigen::Vector3d::UnitY();
};

struct Leaf
{
    int node = 0;
    LeafFrame frame;
};

/// A factorisation with a lock: CHOLMOD's workspaces serve one caller at a time.
struct LockedCholesky
{
    SparseCholesky factor;
    std::mutex mutex;
};

struct InnerNode
{
    int node = 0;
    std::size_t packed = 0;                     ///< Index of its factor in the part's,
    std::unique_ptr<LockedCholesky> supernodal; ///< unless this is present.
};

/// Nodes that one thread works on, with all that is computed for them once.
struct Part
{
    std::size_t first_vertex = 0; ///< Rows of the hierarchy's vertices in this part's workspace.
    std::size_t end_vertex = 0;
    std::vector<Leaf> leaves;
    std::vector<InnerNode> inner; ///< Children before parents.
    PackedCholesky factors;
    std::vector<double>
        inverses; ///< translation_inverse() of the inner nodes, one after the other.
};

LeafFrame leaf_frame(const MultiscaleHierarchy& hierarchy, int node, const Points& reference)
{
    const PatchNode& patch = hierarchy.nodes[to_size(node)];
    const auto& corners = hierarchy.gluing[patch.gluing.begin].vertices;
    const auto corner = [&](std::size_t c) -> Eigen::Vector3d {
        return reference.row(hierarchy.vertices[patch.vertices.begin + to_size(corners[c])])
            .transpose();
    };
    const Eigen::Vector3d edge = corner(1) - corner(0);
    const Eigen::Vector3d normal = edge.cross(corner(2) - corner(0));
    if (!(normal.squaredNorm() > 0.0)) // without area: any orientation will do
        return {};
    return {edge.normalized(), normal.cross(edge).normalized()};
}

/// The normal matrix of the blending: a Laplacian weighted by the number of children that have an
/// edge. The last vertex is held at 0.
void factorise(const MultiscaleHierarchy& hierarchy, Part& part, InnerNode& inner)
{
    const PatchNode& patch = hierarchy.nodes[to_size(inner.node)];
    const int last = patch.vertices.count - 1;
    Eigen::VectorXd diagonal = Eigen::VectorXd::Zero(last + 1);
    std::vector<SymmetricEntry> entries;
    entries.reserve(to_size(patch.edges.count));
    for (int e = 0; e < patch.edges.count; ++e) {
        const PatchEdge& edge = hierarchy.edges[patch.edges.begin + to_size(e)];
        diagonal[edge.lower] += edge.copies;
        diagonal[edge.upper] += edge.copies;
        if (edge.upper != last)
            entries.push_back({edge.upper, edge.lower, -static_cast<double>(edge.copies)});
    }
    diagonal.conservativeResize(last);
    if (last <= supernodal_vertices) {
        inner.packed = part.factors.add(diagonal, entries);
        return;
    }
    std::vector<Eigen::Triplet<double>> triplets;
    triplets.reserve(entries.size() + to_size(last));
    for (int v = 0; v < last; ++v)
        triplets.emplace_back(v, v, diagonal[v]);
    for (const SymmetricEntry& entry : entries)
        triplets.emplace_back(entry.row, entry.column, entry.value);
    SparseMatrix matrix(last, last);
    matrix.setFromTriplets(triplets.begin(), triplets.end());
    inner.supernodal.reset(new LockedCholesky{SparseCholesky(matrix, Ordering::MinimumDegree), {}});
}

void prepare(const MultiscaleHierarchy& hierarchy, const Points& reference, Part& part)
{
    for (Leaf& leaf : part.leaves)
        leaf.frame = leaf_frame(hierarchy, leaf.node, reference);
    for (InnerNode& inner : part.inner) {
        const PatchNode& patch = hierarchy.nodes[to_size(inner.node)];
        const Eigen::MatrixXd inverse = translation_inverse(
            patch.child_count,
            {hierarchy.overlaps.data() + patch.overlaps.begin, to_size(patch.overlaps.count)});
        part.inverses.insert(part.inverses.end(), inverse.data(), inverse.data() + inverse.size());
        factorise(hierarchy, part, inner);
    }
}

/// The third vertex of a triangle over its base, from its lengths: the foot along the base and the
/// height.
Eigen::Vector2d foot_and_height(double base, double first, double second)
{
    const double foot = 0.5 * (base + (first - second) * (first + second) / base);
    return {foot, std::sqrt(std::max(0.0, (first - foot) * (first + foot)))};
}

/// Places the triangles of a leaf one after the other.
void glue(const Leaf& leaf, std::span<const GlueStep> steps, const Target& target,
          PaddedPoint* positions)
{
    const auto lay_out = [&](const GlueStep& step) {
        return foot_and_height(target.lengths[to_size(step.edges[0])],
                               target.lengths[to_size(step.edges[1])],
                               target.lengths[to_size(step.edges[2])]);
    };
    const auto place = [&](int row, const Eigen::Vector3d& point) { positions[row] << point, 1.0; };
    const GlueStep& first = steps.front();
    const Eigen::Vector2d layout = lay_out(first);
    place(first.vertices[0], Eigen::Vector3d::Zero());
    place(first.vertices[1], target.lengths[to_size(first.edges[0])] * leaf.frame.edge);
    place(first.vertices[2], layout[0] * leaf.frame.edge + layout[1] * leaf.frame.height);
    for (const GlueStep& step : steps.subspan(1)) {
        const Eigen::Vector3d a = positions[step.vertices[0]].head<3>();
        const Eigen::Vector3d b = positions[step.vertices[1]].head<3>();
        const Eigen::Vector3d apex = positions[step.vertices[2]].head<3>() - a;
        const Eigen::Vector3d axis = (b - a) / target.lengths[to_size(step.edges[0])];
        const Eigen::Vector3d inward = (apex - axis.dot(apex) * axis).normalized();
        const Eigen::Vector3d normal = axis.cross(inward);
        const Eigen::Vector2d next = lay_out(step);
        const Eigen::Vector2d& bend = target.bends[to_size(step.edges[0])];
        place(step.vertices[3],
              a + next[0] * axis - next[1] * (bend[0] * inward + bend[1] * normal));
    }
}

void diverge(std::span<const PatchEdge> edges, const Target& target, const PaddedPoint* positions,
             std::span<Eigen::Vector4d> divergence)
{
    std::fill(divergence.begin(), divergence.end(), Eigen::Vector4d::Zero());
    for (const PatchEdge& edge : edges) {
        Eigen::Vector4d vector = positions[edge.lower] - positions[edge.upper];
        const double squared = vector.squaredNorm();
        vector *= squared > 0.0 ? target.lengths[to_size(edge.edge)] / std::sqrt(squared) : 0.0;
        divergence[to_size(edge.lower)] += vector;
        divergence[to_size(edge.upper)] -= vector;
    }
}

void solve(const PackedCholesky& factors, const InnerNode& inner, PaddedPoint* x, int unknowns)
{
    if (!inner.supernodal) {
        factors.solve(inner.packed, x);
        return;
    }
    Eigen::MatrixXd columns(unknowns, 3);
    for (int v = 0; v < unknowns; ++v)
        columns.row(v) = x[v].head<3>().transpose();
    {
        const std::lock_guard lock(inner.supernodal->mutex);
        columns = inner.supernodal->factor.solve(columns);
    }
    for (int v = 0; v < unknowns; ++v)
        x[v].head<3>() = columns.row(v).transpose();
}

/// One pose, from the leaves up.
class Pose
{
public:
    Pose(const MultiscaleHierarchy& hierarchy, const RegistrationOptions& options,
         const Target& target, Workspace& top)
        : hierarchy_(hierarchy), options_(options), target_(target), top_(top)
    {
    }

    /// Works through a part; what is below it must be done.
    MultiscalePoseTimes run(const Part& part, Workspace& own) const
    {
        MultiscalePoseTimes times;
        Stopwatch watch;
        for (const Leaf& leaf : part.leaves) {
            const PatchNode& patch = hierarchy_.nodes[to_size(leaf.node)];
            glue(leaf, {hierarchy_.gluing.data() + patch.gluing.begin, to_size(patch.gluing.count)},
                 target_, positions(patch, own));
        }
        watch.add_to(times.interpolation);
        for (const Leaf& leaf : part.leaves)
            diverge_patch(hierarchy_.nodes[to_size(leaf.node)], own);
        watch.add_to(times.blending);
        const double* inverse = part.inverses.data();
        for (const InnerNode& inner : part.inner) {
            const PatchNode& patch = hierarchy_.nodes[to_size(inner.node)];
            const std::span<const PatchNode> children(hierarchy_.nodes.data() + patch.first_child,
                                                      to_size(patch.child_count));
            std::array<const PaddedPoint*, max_patches> patches;
            std::array<Eigen::Matrix3d, max_patches> rotations;
            for (std::size_t k = 0; k < children.size(); ++k)
                patches[k] = positions(children[k], own);
            register_patches(
                {patches.data(), children.size()},
                {hierarchy_.overlaps.data() + patch.overlaps.begin, to_size(patch.overlaps.count)},
                hierarchy_.common.data(), inverse, options_, {rotations.data(), children.size()});
            inverse += (patch.child_count - 1) * (patch.child_count - 1);
            watch.add_to(times.registration);
            blend(part, inner, children, rotations.data(), own);
            watch.add_to(times.blending);
        }
        return times;
    }

private:
    PaddedPoint* positions(const PatchNode& patch, Workspace& own) const
    {
        Workspace& workspace = patch.vertices.begin < own.begin ? top_ : own;
        return workspace.positions.data() + (patch.vertices.begin - workspace.begin);
    }

    Eigen::Vector4d* divergence(const PatchNode& patch, Workspace& own) const
    {
        Workspace& workspace = patch.vertices.begin < own.begin ? top_ : own;
        return workspace.divergence.data() + (patch.vertices.begin - workspace.begin);
    }

    void diverge_patch(const PatchNode& patch, Workspace& own) const
    {
        diverge({hierarchy_.edges.data() + patch.edges.begin, to_size(patch.edges.count)}, target_,
                positions(patch, own), {divergence(patch, own), to_size(patch.vertices.count)});
    }

    void blend(const Part& part, const InnerNode& inner, std::span<const PatchNode> children,
               const Eigen::Matrix3d* rotations, Workspace& own) const
    {
        const PatchNode& patch = hierarchy_.nodes[to_size(inner.node)];
        PaddedPoint* x = positions(patch, own);
        std::fill(x, x + patch.vertices.count, Eigen::Vector4d::Zero());
        for (std::size_t k = 0; k < children.size(); ++k) {
            Eigen::Matrix<double, 4, 3> rotation = Eigen::Matrix<double, 4, 3>::Zero();
            rotation.topRows<3>() = rotations[k];
            const Eigen::Vector4d* term = divergence(children[k], own);
            const int* row = hierarchy_.in_parent.data() + children[k].vertices.begin;
            for (int v = 0; v < children[k].vertices.count; ++v)
                x[row[v]] += rotation.col(0) * term[v][0] + rotation.col(1) * term[v][1] +
                             rotation.col(2) * term[v][2];
        }
        const int last = patch.vertices.count - 1;
        x[last].setZero();
        solve(part.factors, inner, x, last);
        for (int v = 0; v <= last; ++v)
            x[v][3] = 1.0;
        if (patch.parent >= 0)
            diverge_patch(patch, own);
    }

    const MultiscaleHierarchy& hierarchy_;
    const RegistrationOptions& options_;
    const Target& target_;
    Workspace& top_;
};

/// @throws InvalidInput, NumericalError as MultiscaleEmbedder::embed() does.
void check_target(const Topology& topology, const ShapePoint& target)
{
    const Eigen::VectorXd& lengths = target.edge_lengths;
    const Eigen::VectorXd& angles = target.dihedral_angles;
    const Eigen::Index edges = topology.edge_count();
    if (lengths.size() != edges || angles.size() != edges)
        throw InvalidInput(join("target has ", lengths.size(), " edge lengths and ", angles.size(),
                                " dihedral angles, the topology ", edges, " edges"));
    for (Eigen::Index e = 0; e < edges; ++e) {
        if (!std::isfinite(lengths[e]))
            throw InvalidInput(
                join("target: length of edge ", e, " is ", lengths[e], ", must be finite"));
        if (!is_within_angle_limit(angles[e]))
            throw InvalidInput(join("target: dihedral angle of edge ", e, " is ", angles[e],
                                    ", must be within ", angle_limit, " rad"));
    }
    for (int f = 0; f < topology.face_count(); ++f) {
        const double a = lengths[topology.face_edges()(f, 0)];
        const double b = lengths[topology.face_edges()(f, 1)];
        const double c = lengths[topology.face_edges()(f, 2)];
        if (a >= b + c || b >= c + a || c >= a + b)
            throw NumericalError(join("multi-scale embedding: the lengths ", a, ", ", b, ", ", c,
                                      " of face ", f, " break the triangle inequality"));
    }
}

} // namespace

struct MultiscaleEmbedder::State
{
    Topology topology;
    MultiscaleOptions options;
    MultiscaleHierarchy hierarchy;
    std::vector<std::vector<Part>> stages; ///< One after the other; parts of a stage concurrently.
    MultiscaleSetupTimes setup_times;
    Pool<Workspace> top_workspaces, part_workspaces; ///< They outlive a pose.

    [[nodiscard]] std::size_t top_vertices() const
    {
        const Slice& last = hierarchy.nodes[to_size(hierarchy.top - 1)].vertices;
        return last.begin + to_size(last.count);
    }

    void plan_stages();
};

/// First the subtrees, then what is above them, level by level.
void MultiscaleEmbedder::State::plan_stages()
{
    const std::vector<PatchNode>& nodes = hierarchy.nodes;
    stages.emplace_back();
    std::vector<char> is_subtree(to_size(hierarchy.top), 0);
    for (const Subtree& subtree : hierarchy.subtrees) {
        Part part;
        is_subtree[to_size(subtree.root)] = 1;
        part.first_vertex = part.end_vertex = top_vertices();
        if (subtree.end > subtree.begin) {
            const Slice& last = nodes[to_size(subtree.end - 1)].vertices;
            part.first_vertex = nodes[to_size(subtree.begin)].vertices.begin;
            part.end_vertex = last.begin + to_size(last.count);
        }
        const auto add = [&](int node) {
            if (nodes[to_size(node)].is_leaf())
                part.leaves.push_back({node, {}});
            else
                part.inner.push_back({node, 0, nullptr});
        };
        for (int node = subtree.end - 1; node >= subtree.begin; --node)
            add(node);
        add(subtree.root);
        stages.front().push_back(std::move(part));
    }
    std::vector<int> depth(to_size(hierarchy.top), 0);
    std::vector<std::vector<Part>> levels;
    for (int node = 0; node < hierarchy.top; ++node) {
        if (node > 0)
            depth[to_size(node)] = depth[to_size(nodes[to_size(node)].parent)] + 1;
        if (is_subtree[to_size(node)] != 0)
            continue;
        levels.resize(to_size(depth[to_size(node)] + 1));
        Part part;
        part.first_vertex = part.end_vertex = top_vertices();
        part.inner.push_back({node, 0, nullptr});
        levels.back().push_back(std::move(part));
    }
    std::move(levels.rbegin(), levels.rend(), std::back_inserter(stages));
}

void check(const MultiscaleOptions& options)
{
    require(options.children >= 4 && options.children <= max_patches, "MultiscaleOptions.children",
            options.children, join("in [4, ", max_patches, "]"));
    check(options.registration);
}

MultiscaleEmbedder::MultiscaleEmbedder(const Topology& topology, const Points& reference,
                                       const MultiscaleOptions& options)
    : state_(new State{topology, options, {}, {}, {}, {}, {}})
{
    check(options);
    State& state = *state_;
    Stopwatch watch;
    state.hierarchy =
        build_hierarchy(topology, reference, {.seed = options.seed, .children = options.children});
    watch.add_to(state.setup_times.splitting);
    state.plan_stages();
    for (std::vector<Part>& stage : state.stages)
        parallel_for(stage.size(), 1, [&](std::size_t begin, std::size_t end) {
            for (std::size_t i = begin; i < end; ++i)
                prepare(state.hierarchy, reference, stage[i]);
        });
    watch.add_to(state.setup_times.factorising);
}

MultiscaleEmbedder::~MultiscaleEmbedder() = default;
MultiscaleEmbedder::MultiscaleEmbedder(MultiscaleEmbedder&&) noexcept = default;
MultiscaleEmbedder& MultiscaleEmbedder::operator=(MultiscaleEmbedder&&) noexcept = default;

MultiscaleEmbedding MultiscaleEmbedder::embed(const ShapePoint& target) const
{
    State& state = *state_;
    MultiscaleEmbedding result;
    Stopwatch wall;
    check_target(state.topology, target);
    Target local{{target.edge_lengths.data(), to_size(state.topology.edge_count())},
                 std::vector<Eigen::Vector2d>(to_size(state.topology.edge_count()))};
    parallel_for(local.bends.size(), 4096, [&](std::size_t begin, std::size_t end) {
        for (std::size_t e = begin; e < end; ++e) {
            const double angle = target.dihedral_angles[static_cast<Eigen::Index>(e)];
            local.bends[e] = {std::cos(angle), std::sin(angle)};
        }
    });

    const auto top = state.top_workspaces.borrow();
    top->cover(0, state.top_vertices());
    const Pose pose(state.hierarchy, state.options.registration, local, *top);
    for (const std::vector<Part>& stage : state.stages) {
        std::vector<MultiscalePoseTimes> times(stage.size());
        parallel_for(stage.size(), 1, [&](std::size_t begin, std::size_t end) {
            const auto own = state.part_workspaces.borrow();
            for (std::size_t i = begin; i < end; ++i) {
                own->cover(stage[i].first_vertex, stage[i].end_vertex);
                times[i] = pose.run(stage[i], *own);
            }
        });
        for (const MultiscalePoseTimes& part : times) {
            result.times.interpolation += part.interpolation;
            result.times.registration += part.registration;
            result.times.blending += part.blending;
        }
    }

    result.points.resize(state.topology.vertex_count(), 3);
    for (int v = 0; v < state.topology.vertex_count(); ++v)
        result.points.row(state.hierarchy.vertices[to_size(v)]) =
            top->positions[to_size(v)].head<3>().transpose();
    result.points.rowwise() -= result.points.colwise().mean().eval();
    if (!result.points.allFinite())
        throw NumericalError("multi-scale embedding: a position is not finite");
    wall.add_to(result.times.total);
    return result;
}

const MultiscaleSetupTimes& MultiscaleEmbedder::setup_times() const
{
    return state_->setup_times;
}

} // namespace shape
