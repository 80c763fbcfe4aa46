// SPDX-License-Identifier: MIT

#include "libshape/conformal/flat_metric.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "libshape/base/error.h"
#include "libshape/base/format.h"
#include "libshape/base/to_size.h"
#include "libshape/conformal/angle_defect_energy.h"
#include "libshape/conformal/layout.h"
#include "libshape/conformal/scale_factors.h"

namespace shape::internal {
namespace {

bool adjacent(const IntrinsicTriangulation& t, int halfedge, int vertex)
{
    const std::vector<int> ring = t.ring(halfedge);
    return std::any_of(ring.begin(), ring.end(), [&](int h) { return t.target(h) == vertex; });
}

/// Flips an edge of the removed star unless a loop or a double edge would come of it.
bool flip_within_complex(IntrinsicTriangulation& t, int edge)
{
    const int h = t.halfedge(edge);
    const int o = t.opposite(h);
    const int c = t.source(Topology::previous(h));
    const int d = t.source(Topology::previous(o));
    if (!t.is_flippable(edge) || c == d || t.ring(h).size() <= 3 || t.ring(o).size() <= 3 ||
        adjacent(t, Topology::previous(h), d))
        return false;
    t.flip(edge);
    return true;
}

/// Newton's method ends above this [rad] only where faces are all but broken.
constexpr double stuck_residual = 1e-10;

class Flattening
{
public:
    Flattening(IntrinsicTriangulation t, int removed_vertex, Eigen::VectorXd factors,
               const TriangulationRepairOptions& options)
        : options_(options),
          t_(std::move(t)),
          u_(std::move(factors)),
          removed_(removed_vertex),
          released_(to_size(t_.edge_count()), 0)
    {
        fix_boundary();
        double mean = 0.0;
        for (const int h : boundary_)
            mean += u_[t_.source(h)] / static_cast<double>(boundary_.size());
        for (int v = 0; v < t_.vertex_count(); ++v)
            if (problem_.is_free[to_size(v)])
                u_[v] = mean;
    }

    FlatMetric run()
    {
        int newton_steps = 0;
        for (int round = 0;; ++round) {
            ScaleFactors solution = solve_scale_factors(t_, u_, problem_);
            newton_steps += solution.iterations;
            t_ = solution.triangulation;
            u_ = solution.u;
            find_boundary(); // flips renumber half-edges
            const bool done = round == options_.max_rounds ||
                              !repair(solution.broken_faces, solution.residual, round);
            if (!done) {
                fix_boundary();
                continue;
            }
            solution.system.factor(solution.edge_weights);
            PlanarLayout layout =
                lay_out_disc(t_, u_, boundary_, solution.edge_weights, solution.system);
            const bool all_released =
                std::all_of(released_.begin(), released_.end(), [](char r) { return r != 0; });
            return {t_,
                    u_,
                    boundary_,
                    std::move(layout),
                    solution.residual,
                    newton_steps,
                    round,
                    all_released,
                    std::move(solution.broken_faces)};
        }
    }

private:
    void find_boundary()
    {
        boundary_.clear();
        const std::vector<int> first = t_.first_halfedges();
        if (removed_ >= 0) {
            star_ = t_.ring(first[to_size(removed_)]);
            for (const int h : star_)
                boundary_.push_back(t_.opposite(Topology::next(h)));
            std::reverse(boundary_.begin(), boundary_.end());
            return;
        }
        int start = 0;
        while (t_.opposite(start) >= 0)
            ++start;
        for (int h = start; boundary_.empty() || h != start;) {
            boundary_.push_back(h);
            h = t_.ring(first[to_size(t_.target(h))]).front();
        }
    }

    /// Makes the vertices of the boundary the fixed ones.
    void fix_boundary()
    {
        find_boundary();
        problem_.removed_vertex = removed_;
        problem_.is_free.assign(to_size(t_.vertex_count()), 1);
        problem_.may_flip = released_;
        if (removed_ >= 0)
            problem_.is_free[to_size(removed_)] = 0;
        for (const int h : star_) {
            u_[t_.target(h)] = -2.0 * t_.log_lengths()[t_.edge(h)];
            problem_.may_flip[to_size(t_.edge(h))] = 0;
        }
        for (const int h : boundary_) {
            problem_.is_free[to_size(t_.source(h))] = 0;
            problem_.may_flip[to_size(t_.edge(h))] = 0;
        }
    }

    /// Prepares the next round: flips in the star of the removed vertex, releases more edges.
    /// Returns whether anything changed.
    bool repair(std::vector<int> broken_faces, double residual, int round)
    {
        const std::vector<char> released_before = released_;
        bool flipped = false;
        const bool is_solved = broken_faces.empty() && residual <= stuck_residual;
        if (round == options_.local_rounds && !is_solved)
            release_all();
        // Repairing the worse half often repairs the others.
        std::sort(broken_faces.begin(), broken_faces.end(), [&](int f, int g) {
            return std::pair(-excess(f), f) < std::pair(-excess(g), g);
        });
        broken_faces.resize((broken_faces.size() + 1) / 2);
        std::vector<int> link_edges;
        for (const int f : broken_faces) {
            const std::array<double, 3> sides = scaled_sides(t_, u_, f);
            const auto longest = std::max_element(sides.begin(), sides.end()) - sides.begin();
            const int e = t_.edge(3 * f + static_cast<int>(longest));
            if (is_boundary(e))
                link_edges.push_back(e);
            else if (!released_[to_size(e)])
                released_[to_size(e)] = 1;
            else
                release_around(f);
        }
        // Reflex vertices leave the link if they may, vertices that break a link edge join it. A defect
        // within 1e-9 of pi is a straight angle but for what Newton's method leaves (stuck_residual).
        const Eigen::VectorXd defects = measure_angle_defects(t_, u_, removed_).defects;
        for (const int h : star_)
            if (released_[to_size(t_.edge(h))] && defects[t_.target(h)] < std::numbers::pi - 1e-9)
                flipped |= flip_within_complex(t_, t_.edge(h));
        if (removed_ >= 0)
            for (const int e : link_edges)
                flipped |= flip_within_complex(t_, e);
        if (!flipped && released_ == released_before && !is_solved)
            release_all();
        return flipped || released_ != released_before;
    }

    void release_all() { std::fill(released_.begin(), released_.end(), static_cast<char>(1)); }

    /// How much longer the longest side is than the others together, in logarithms.
    [[nodiscard]] double excess(int face) const
    {
        std::array<double, 3> sides = scaled_sides(t_, u_, face);
        std::sort(sides.begin(), sides.end());
        return sides[2] - sides[1] - std::log1p(std::exp(sides[0] - sides[1]));
    }

    [[nodiscard]] bool is_boundary(int edge) const
    {
        return std::any_of(boundary_.begin(), boundary_.end(),
                           [&](int h) { return t_.edge(h) == edge; });
    }

    /// Releases the edges of all faces that touch a face.
    void release_around(int face)
    {
        for (int c = 0; c < 3; ++c)
            for (const int h : t_.ring(3 * face + c))
                for (const int side : {h, Topology::next(h), Topology::previous(h)})
                    released_[to_size(t_.edge(side))] = 1;
    }

    TriangulationRepairOptions options_;
    IntrinsicTriangulation t_;
    Eigen::VectorXd u_;
    int removed_;
    std::vector<char> released_;
    std::vector<int> star_; // half-edges out of the removed vertex
    std::vector<int> boundary_;
    ScaleFactorProblem problem_;
};

} // namespace

FlatMetric flatten_disc(IntrinsicTriangulation triangulation, const Eigen::VectorXd& factors,
                        const TriangulationRepairOptions& options)
{
    check(options);
    if (factors.size() != triangulation.vertex_count())
        throw InvalidInput(join("factors has ", factors.size(), " entries, the mesh ",
                                triangulation.vertex_count(), " vertices"));
    return Flattening(std::move(triangulation), -1, factors, options).run();
}

FlatMetric flatten_punctured_sphere(IntrinsicTriangulation triangulation, int removed_vertex,
                                    const TriangulationRepairOptions& options)
{
    check(options);
    const Eigen::VectorXd factors = Eigen::VectorXd::Zero(triangulation.vertex_count());
    return Flattening(std::move(triangulation), removed_vertex, factors, options).run();
}

} // namespace shape::internal
