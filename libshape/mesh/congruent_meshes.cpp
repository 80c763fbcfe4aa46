// SPDX-License-Identifier: MIT

#include "libshape/mesh/congruent_meshes.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>
#include <set>
#include <utility>

#include "libshape/base/format.h"
#include "libshape/base/rounded.h"
#include "libshape/base/threads.h"
#include "libshape/base/to_size.h"
#include "libshape/mesh/alignment.h"
#include "libshape/mesh/coordinate_spacing.h"
#include "libshape/mesh/edge_lengths.h"
#include "libshape/mesh/oddities.h"
#include "libshape/mesh/partition.h"

namespace shape::internal {
namespace {

/// Of the diagonal: what is nearer is a copy whatever the others do; what is as near as their numbers tell, or nearer
/// than the others ever are, may be one.
constexpr double near_enough = 1e-6;
constexpr double most_rounding = 1e-3;
constexpr double most_difference = 1e-4;

/// So many of them make a sequence of small steps.
constexpr std::size_t most_near = 32;

using Ends = std::pair<Eigen::Index, Eigen::Index>;

/// Two vertices at either end of the mesh: where sizes are equal, as of meshes that were scaled to one, their distance
/// still tells nearly all pairs apart.
Ends far_vertices(const Points& points)
{
    Eigen::Index axis = 0;
    (points.colwise().maxCoeff() - points.colwise().minCoeff()).maxCoeff(&axis);
    Ends ends;
    points.col(axis).minCoeff(&ends.first);
    points.col(axis).maxCoeff(&ends.second);
    return ends;
}

/// What tells most pairs apart at once, and how near the others must be [length].
struct Measures
{
    double size = 0.0;   ///< Sum of the edges.
    double extent = 0.0; ///< Distance of the far vertices.
    double diagonal = 0.0;
    double spacing = 0.0;
};

Measures measure(const Topology& topology, const Ends& ends, const Points& points)
{
    return {edge_lengths(topology, points).sum(),
            (points.row(ends.first) - points.row(ends.second)).norm(),
            bounding_box_diagonal(points), coordinate_spacing(points)};
}

std::vector<Measures> measure_all(const Topology& topology, const Ends& ends,
                                  std::span<const Points> meshes)
{
    std::vector<Measures> measures(meshes.size());
    parallel_for(meshes.size(), 8, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i)
            measures[i] = measure(topology, ends, meshes[i]);
    });
    return measures;
}

/// Compares edge by edge, some here and there first, as two different meshes of one size seldom agree in more than a
/// few.
bool have_equal_lengths(const Topology& topology, const Points& a, const Points& b, double bound)
{
    const auto length = [&](const Points& points, int e) {
        const int h = topology.edge_halfedges()(e, 0);
        return (points.row(topology.source(h)) - points.row(topology.target(h))).norm();
    };
    const int step = std::max(1, topology.edge_count() / 64);
    for (int first = 0; first < step; ++first)
        for (int e = first; e < topology.edge_count(); e += step)
            if (!(std::abs(length(a, e) - length(b, e)) <= bound))
                return false;
    return true;
}

/// Distances of the vertices of b from those of a after the best rigid motion [length].
Eigen::VectorXd distances_in_place(const Points& a, const Points& b)
{
    return (best_rigid_motion(b, a)(b) - a).rowwise().norm();
}

double root_mean_square(const Eigen::VectorXd& values)
{
    return std::sqrt(values.squaredNorm() / static_cast<double>(values.size()));
}

bool are_congruent(const Topology& topology, const Points& a, const Points& b, double bound)
{
    return have_equal_lengths(topology, a, b, bound) &&
           distances_in_place(a, b).maxCoeff() <= bound;
}

/// The meshes by their size.
std::vector<std::size_t> order_of(const std::vector<Measures>& measures)
{
    std::vector<std::size_t> order(measures.size());
    for (std::size_t i = 0; i < order.size(); ++i)
        order[i] = i;
    std::ranges::stable_sort(order, {}, [&](std::size_t i) { return measures[i].size; });
    return order;
}

/// Meshes that are near enough, by the first one in order of their sizes, which stands for them; alone where there is
/// no other.
std::vector<std::vector<std::size_t>> equal_meshes(const Topology& topology,
                                                   std::span<const Points> meshes,
                                                   const std::vector<Measures>& measures)
{
    const std::vector<std::size_t> order = order_of(measures);
    std::vector<char> is_listed(meshes.size(), 0);
    std::vector<std::vector<std::size_t>> lists;
    for (std::size_t k = 0; k < order.size(); ++k) {
        const std::size_t first = order[k];
        if (is_listed[first] != 0)
            continue;
        std::vector<std::size_t> list{first};
        const double bound = near_enough * measures[first].diagonal;
        const double largest = measures[first].size + bound * topology.edge_count();
        for (std::size_t n = k + 1; n < order.size() && measures[order[n]].size <= largest; ++n)
            if (is_listed[order[n]] == 0 &&
                std::abs(measures[order[n]].extent - measures[first].extent) <= 2.0 * bound &&
                are_congruent(topology, meshes[first], meshes[order[n]], bound)) {
                is_listed[order[n]] = 1;
                list.push_back(order[n]);
            }
        lists.push_back(std::move(list));
    }
    return lists;
}

/// Another mesh, nearly in the place of one after the best rigid motion.
struct Neighbour
{
    std::size_t place = 0;
    double farthest = 0.0; ///< Of its vertices [length].
    double usual = 0.0;    ///< Root of the mean of the squares of all [length].
};

/// Copies among meshes of which no two are equal.
class NearCopies
{
public:
    /// @param order  Meshes by their size; a place is an index into it.
    NearCopies(const Topology& topology, std::span<const Points> meshes,
               const std::vector<Measures>& measures, const std::vector<std::size_t>& order)
        : topology_(topology), meshes_(meshes), measures_(measures), order_(order)
    {
        constexpr Eigen::Index most_drawn = 64;
        const Eigen::Index count = topology.vertex_count();
        std::vector<Eigen::Index> drawn;
        for (Eigen::Index k = 0; k < std::min(count, most_drawn); ++k)
            drawn.push_back(k * count / std::min(count, most_drawn));
        for (const std::size_t i : order_) {
            coarsest_ = std::max(coarsest_, measures_[i].spacing);
            drawn_.emplace_back(meshes_[i](drawn, Eigen::all));
        }
    }

    /// What is a copy of the mesh at a place.
    [[nodiscard]] std::vector<Neighbour> of(std::size_t place) const
    {
        std::vector<Neighbour> near = neighbours_of(place);
        if (near.size() > most_near)
            return {};
        double next = 0.0; // of what is none; 0: of all others
        for (; !near.empty(); near.pop_back()) {
            if (const std::optional<double> ratio = least_ratio(place, near)) {
                const double apart = *ratio * near.back().usual;
                if (next > 0.0 ? next >= apart : !has_other_within(place, near, apart))
                    break;
            }
            next = near.back().usual;
        }
        return near;
    }

private:
    [[nodiscard]] const Measures& at(std::size_t place) const { return measures_[order_[place]]; }

    /// Calls visit(other) for the others, those of the nearest sizes first, until it returns false or they differ by
    /// more than the window.
    template <class Visit>
    void visit_by_size(std::size_t place, double window, const Visit& visit) const
    {
        const double infinity = std::numeric_limits<double>::infinity();
        std::size_t below = place;
        std::size_t above = place + 1;
        while (true) {
            const double down = below > 0 ? at(place).size - at(below - 1).size : infinity;
            const double up = above < order_.size() ? at(above).size - at(place).size : infinity;
            const double nearer = std::min(down, up);
            if (nearer > window || nearer == infinity || !visit(down <= up ? --below : above++))
                return;
        }
    }

    /// What two meshes may differ by, each coordinate half a spacing off in both, and as much again for the motion.
    [[nodiscard]] double rounding(std::size_t place, double spacing) const
    {
        return std::min(most_rounding * at(place).diagonal,
                        std::numbers::sqrt3 * (at(place).spacing + spacing));
    }

    /// Those that could be copies, the nearest first; one too many if they are a sequence.
    [[nodiscard]] std::vector<Neighbour> neighbours_of(std::size_t place) const
    {
        const Points& points = meshes_[order_[place]];
        const double reach =
            std::max(most_difference * at(place).diagonal, rounding(place, coarsest_));
        std::vector<Neighbour> near;
        visit_by_size(place, 2.0 * reach * topology_.edge_count(), [&](std::size_t other) {
            const Points& others = meshes_[order_[other]];
            if (std::abs(at(place).extent - at(other).extent) > 2.0 * reach ||
                !have_equal_lengths(topology_, points, others, 2.0 * reach))
                return true;
            const Eigen::VectorXd distances = distances_in_place(points, others);
            if (distances.maxCoeff() <= reach)
                near.push_back({other, distances.maxCoeff(), root_mean_square(distances)});
            return near.size() <= most_near;
        });
        std::ranges::sort(near, {}, &Neighbour::usual);
        return near;
    }

    /// How many times further than these all others must be for them to be copies; nothing if they are none.
    [[nodiscard]] std::optional<double> least_ratio(std::size_t place,
                                                    const std::vector<Neighbour>& near) const
    {
        constexpr double of_rounding = 10.0;
        constexpr double of_difference = 1000.0;
        constexpr std::size_t least_others = 3; // that show how far meshes are apart
        if (std::ranges::all_of(near, [&](const Neighbour& n) {
                return n.farthest <= rounding(place, at(n.place).spacing);
            }))
            return of_rounding;
        if (order_.size() > near.size() + least_others &&
            std::ranges::all_of(near, [&](const Neighbour& n) {
                return n.farthest <= most_difference * at(place).diagonal;
            }))
            return of_difference;
        return std::nullopt;
    }

    [[nodiscard]] bool has_other_within(std::size_t place, const std::vector<Neighbour>& near,
                                        double distance) const
    {
        bool found = false;
        visit_by_size(place, std::numeric_limits<double>::max(), [&](std::size_t other) {
            const bool is_near =
                std::ranges::any_of(near, [&](const Neighbour& n) { return n.place == other; });
            found = !is_near &&
                    root_mean_square(distances_in_place(drawn_[place], drawn_[other])) < distance;
            return !found;
        });
        return found;
    }

    const Topology& topology_;
    std::span<const Points> meshes_;
    const std::vector<Measures>& measures_;
    const std::vector<std::size_t>& order_;
    std::vector<Points> drawn_; ///< Some vertices of each.
    double coarsest_ = 0.0;     ///< Spacing of all [length].
};

} // namespace

std::vector<Copies> congruent_meshes(const Topology& topology, std::span<const Points> meshes)
{
    if (meshes.empty())
        return {};
    const std::vector<Measures> measures =
        measure_all(topology, far_vertices(meshes.front()), meshes);
    const auto equal = equal_meshes(topology, meshes, measures);
    std::vector<std::size_t> order;
    for (const std::vector<std::size_t>& list : equal)
        order.push_back(list.front());
    const NearCopies near_copies(topology, meshes, measures, order);
    std::vector<std::vector<Neighbour>> found(order.size());
    parallel_for(order.size(), 1,
                 [&](std::size_t begin, std::size_t) { found[begin] = near_copies.of(begin); });

    Partition partition(order.size());
    for (std::size_t k = 0; k < order.size(); ++k)
        for (const Neighbour& n : found[k])
            partition.unite(static_cast<int>(k), static_cast<int>(n.place));
    std::vector<Copies> all(order.size());
    for (std::size_t k = 0; k < order.size(); ++k) {
        Copies& copies = all[to_size(partition.root(static_cast<int>(k)))];
        copies.meshes.insert(copies.meshes.end(), equal[k].begin(), equal[k].end());
        for (const Neighbour& n : found[k])
            copies.difference =
                std::max(copies.difference, n.farthest / measures[order[k]].diagonal);
    }
    std::erase_if(all, [](const Copies& copies) { return copies.meshes.size() < 2; });
    for (Copies& copies : all)
        std::ranges::sort(copies.meshes);
    std::ranges::sort(all, {}, &Copies::meshes);
    return all;
}

std::string describe(const Copies& copies, const std::vector<std::string>& names)
{
    return join(list_names(names, copies.meshes), " are copies of one mesh, in place or moved",
                copies.difference > 0.0 ? join(", up to ", rounded(copies.difference),
                                               " of the diagonal apart, as rounding leaves them")
                                        : "",
                "; statistics count each of them: keep one");
}

std::vector<std::size_t> meshes_to_compare(const MeshStream& stream, std::span<const Points> meshes,
                                           const Progress& progress)
{
    constexpr Eigen::Index most_others = 8;
    constexpr std::uint64_t bytes_of_block = 64U << 20U;
    const Topology& topology = stream.topology;
    const Ends ends = far_vertices(meshes.front());
    const std::vector<Measures> measures = measure_all(topology, ends, meshes);
    const std::vector<std::size_t> order = order_of(measures);
    const auto bound_of = [&](std::size_t i) { return 2.0 * most_rounding * measures[i].diagonal; };
    double widest = 0.0;
    for (std::size_t i = 0; i < meshes.size(); ++i)
        widest = std::max(widest, bound_of(i) * topology.edge_count());
    const auto near_to = [&](const Points& points) {
        const Measures m = measure(topology, ends, points);
        std::vector<std::size_t> near;
        for (auto i = std::ranges::lower_bound(order, m.size - widest, {},
                                               [&](std::size_t k) { return measures[k].size; });
             i != order.end() && measures[*i].size <= m.size + widest; ++i)
            if (std::abs(measures[*i].size - m.size) <= bound_of(*i) * topology.edge_count() &&
                std::abs(measures[*i].extent - m.extent) <= bound_of(*i) &&
                have_equal_lengths(topology, meshes[*i], points, bound_of(*i)))
                near.push_back(*i);
        return near;
    };

    std::set<std::size_t> chosen;
    for (Eigen::Index k = 0; k < std::min(stream.size(), most_others); ++k)
        chosen.insert(to_size(k * stream.size() / std::min(stream.size(), most_others)));
    std::vector<std::size_t> counts(meshes.size());
    const auto block = static_cast<Eigen::Index>(std::clamp<std::uint64_t>(
        bytes_of_block / std::max<std::uint64_t>(stream.bytes_per_mesh, 1), 1, 64));
    for_each_block(
        stream, 0, stream.size(), block, [&](Eigen::Index first, const Collection& part) {
            std::vector<std::vector<std::size_t>> near(part.points.size());
            parallel_for(near.size(), 1,
                         [&](std::size_t i, std::size_t) { near[i] = near_to(part.points[i]); });
            for (std::size_t i = 0; i < near.size(); ++i)
                for (const std::size_t mesh : near[i])
                    if (counts[mesh]++ <= most_near) // one more: a sequence
                        chosen.insert(to_size(first) + i);
            if (progress)
                progress("comparing", to_size(first) + near.size(), stream.names.size());
        });
    return {chosen.begin(), chosen.end()};
}

} // namespace shape::internal
