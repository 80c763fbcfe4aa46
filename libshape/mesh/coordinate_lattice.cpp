// SPDX-License-Identifier: MIT

#include "libshape/mesh/coordinate_lattice.h"

#include <Eigen/Cholesky>
#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>
#include <vector>

#include "libshape/base/order_statistics.h"
#include "libshape/base/to_size.h"

namespace shape::internal {
namespace {

constexpr double most_levels = 1e9; // an int holds them
constexpr double rounding = 0.02;   // of a step: numbers are rounded once more where units change

/// The greatest common divisor of two lengths, of which remainders up to `tolerance` are none; 0 if it is below `least`.
double common_divisor(double a, double b, double least, double tolerance)
{
    while (b > tolerance) {
        if (b < least)
            return 0.0;
        double rest = std::fmod(a, b);
        rest = std::min(rest, b - rest);
        a = b;
        b = rest;
    }
    return a;
}

/// The step of ascending numbers; 0 if there is none above `least`. It is measured again at each number over all before, so that
/// the error of the first gap does not grow.
double step_of(const std::vector<double>& sorted, double least)
{
    const double tolerance = rounding * least;
    double step = 0.0;
    double count = 0.0; // of steps from the first one on
    for (std::size_t k = 1; k < sorted.size(); ++k) {
        const double gap = sorted[k] - sorted[k - 1];
        if (gap <= tolerance)
            continue;
        if (step == 0.0) {
            step = gap;
            count = 1.0;
        } else {
            double rest = std::abs(gap - std::round(gap / step) * step);
            if (rest > tolerance) {
                const double finer = common_divisor(step, rest, least, tolerance);
                if (finer == 0.0)
                    return 0.0;
                count *= std::round(step / finer);
                step = finer;
            }
            count += std::round(gap / step);
            step = (sorted[k] - sorted.front()) / count;
        }
        if (!(step > least))
            return 0.0;
    }
    return step;
}

/// The levels that have vertices, ascending, and how many.
std::vector<std::pair<int, int>> counts_of(const Lattice& lattice)
{
    std::vector<int> levels(lattice.levels.begin(), lattice.levels.end());
    std::erase(levels, -1);
    std::sort(levels.begin(), levels.end());
    std::vector<std::pair<int, int>> counts;
    for (const int level : levels)
        if (counts.empty() || counts.back().first != level)
            counts.emplace_back(level, 1);
        else
            ++counts.back().second;
    return counts;
}

/// @param chosen  Vertices.
std::optional<Lattice> lattice_of(const Eigen::VectorXd& coordinates,
                                  const std::vector<Eigen::Index>& chosen, double least,
                                  int least_levels)
{
    std::vector<double> sorted;
    for (const Eigen::Index v : chosen)
        sorted.push_back(coordinates[v]);
    std::sort(sorted.begin(), sorted.end());
    Lattice lattice;
    lattice.step = step_of(sorted, least);
    if (lattice.step == 0.0 || sorted.back() - sorted.front() > most_levels * lattice.step)
        return std::nullopt;
    lattice.levels = Eigen::VectorXi::Constant(coordinates.size(), -1);
    for (const Eigen::Index v : chosen) {
        const double steps = (coordinates[v] - sorted.front()) / lattice.step;
        if (std::abs(steps - std::round(steps)) > rounding)
            return std::nullopt;
        lattice.levels[v] = static_cast<int>(std::round(steps));
    }
    lattice.level_count = static_cast<int>(counts_of(lattice).size());
    if (lattice.level_count < least_levels)
        return std::nullopt;
    return lattice;
}

/// Which part of the edges runs by so much at most along an axis.
struct Runs
{
    double one_level = 0.0; ///< To the next level that has vertices.
    double two_levels = 0.0;
    double two_steps = 0.0; ///< Whether levels between have vertices or not.
};

Runs runs_of(const Faces& faces, const Lattice& lattice)
{
    const std::vector<std::pair<int, int>> counts = counts_of(lattice);
    Eigen::VectorXi ranks = lattice.levels;
    for (int& rank : ranks)
        if (rank >= 0)
            rank = static_cast<int>(
                std::lower_bound(counts.begin(), counts.end(), std::pair(rank, 0)) -
                counts.begin());
    Runs runs;
    double all = 0.0;
    for (const auto& face : faces.rowwise())
        for (int c = 0; c < 3; ++c) {
            const int a = face[c];
            const int b = face[(c + 1) % 3];
            if (ranks[a] < 0 || ranks[b] < 0)
                continue;
            const int levels = std::abs(ranks[a] - ranks[b]);
            all += 1.0;
            runs.one_level += levels <= 1 ? 1.0 : 0.0;
            runs.two_levels += levels <= 2 ? 1.0 : 0.0;
            runs.two_steps += std::abs(lattice.levels[a] - lattice.levels[b]) <= 2 ? 1.0 : 0.0;
        }
    if (all > 0.0)
        for (double* const share : {&runs.one_level, &runs.two_levels, &runs.two_steps})
            *share /= all;
    return runs;
}

/// Whether many vertices share each of a few levels, with none beside them.
bool has_lonely_levels(const Lattice& lattice)
{
    constexpr int least_shared = 3;
    const std::vector<std::pair<int, int>> counts = counts_of(lattice);
    int lonely = 0;
    int all = 0;
    for (std::size_t k = 0; k < counts.size(); ++k) {
        const auto [level, count] = counts[k];
        all += count;
        if (count >= least_shared && (k == 0 || counts[k - 1].first + 1 < level) &&
            (k + 1 == counts.size() || counts[k + 1].first > level + 1))
            lonely += count;
    }
    return 2 * lonely >= all;
}

/// How an axis looks: 1 of slices or plates, 2 of what may be so, as edges run by two steps at most; else 0.
int kind_of(const Faces& faces, const Lattice& lattice)
{
    constexpr double nearly_all = 0.99;
    constexpr double most =
        0.8; // of plates cut into few triangles; of rounded ones edges run farther
    const Runs runs = runs_of(faces, lattice);
    if (runs.one_level >= nearly_all || (runs.two_levels >= most && has_lonely_levels(lattice)))
        return 1;
    return runs.two_steps >= nearly_all ? 2 : 0;
}

/// Whether the surface has flat steps along an axis, with slanted faces between them: what rounding to steps of more than an edge
/// makes of a smooth one. Slices have no vertices but on their rims, and vertical walls are built.
bool is_terraced(const Faces& faces, const Points& points, const Lattice& lattice,
                 Eigen::Index axis)
{
    constexpr double least_within = 0.02;     // of all vertices
    constexpr std::size_t least_plateaus = 3; // two are the ends
    constexpr double upright = 0.05;
    std::vector<char> is_within(to_size(points.rows()), 1);
    int risers = 0;
    int slanted = 0;
    for (const auto& face : faces.rowwise())
        for (int c = 0; c < 3; ++c) {
            const int a = face[c];
            const int b = face[(c + 1) % 3];
            if (lattice.levels[a] == lattice.levels[b])
                continue;
            is_within[to_size(a)] = is_within[to_size(b)] = 0;
            Eigen::RowVector3d along = points.row(a) - points.row(b);
            const double rise = std::abs(along[axis]);
            along[axis] = 0.0;
            ++risers;
            slanted += along.norm() > upright * rise ? 1 : 0;
        }
    std::vector<int> plateaus;
    for (std::size_t v = 0; v < is_within.size(); ++v)
        if (is_within[v] != 0)
            plateaus.push_back(lattice.levels[static_cast<Eigen::Index>(v)]);
    const auto within = static_cast<double>(plateaus.size());
    std::sort(plateaus.begin(), plateaus.end());
    plateaus.erase(std::unique(plateaus.begin(), plateaus.end()), plateaus.end());
    return plateaus.size() >= least_plateaus &&
           within >= least_within * static_cast<double>(points.rows()) && 2 * slanted > risers;
}

/// Whether the mesh is a part made of planes: faces lie in one plane with their neighbours or meet them in a sharp edge, and
/// all have an area. Of a smooth surface that was rounded neighbours meet in small angles too.
bool is_made_of_planes(const Faces& faces, const Points& points)
{
    constexpr double nearly_all = 0.99;
    constexpr double flat = 1e-5; // sine: single precision, of faces that are not slivers
    constexpr double sharp = 0.9; // cosine: 26 degrees
    Points normals(faces.rows(), 3);
    std::vector<std::pair<std::pair<int, int>, Eigen::Index>> sides;
    for (Eigen::Index f = 0; f < faces.rows(); ++f) {
        const Eigen::Vector3d a = points.row(faces(f, 0));
        const Eigen::Vector3d b = points.row(faces(f, 1));
        const Eigen::Vector3d c = points.row(faces(f, 2));
        const Eigen::Vector3d normal = (b - a).cross(c - a);
        if (!(normal.norm() > flat * (b - a).norm() * (c - a).norm()))
            return false;
        normals.row(f) = normal.normalized().transpose();
        for (int k = 0; k < 3; ++k)
            sides.emplace_back(std::minmax({faces(f, k), faces(f, (k + 1) % 3)}), f);
    }
    std::sort(sides.begin(), sides.end());
    double planar = 0.0;
    double all = 0.0;
    for (std::size_t k = 1; k < sides.size(); ++k) {
        if (sides[k].first != sides[k - 1].first)
            continue;
        const Eigen::Vector3d n = normals.row(sides[k].second);
        const Eigen::Vector3d m = normals.row(sides[k - 1].second);
        all += 1.0;
        planar += n.cross(m).norm() < flat || n.dot(m) < sharp ? 1.0 : 0.0;
    }
    return planar >= nearly_all * all;
}

/// Whether vertices are as marching cubes leave them, in the middle of an edge between two voxels.
bool are_halfway(const std::array<std::optional<Lattice>, 3>& lattices)
{
    constexpr double share = 0.97;
    std::array<double, 8> kinds{}; // by the parities
    double all = 0.0;
    for (const auto& lattice : lattices)
        if (!lattice || lattice->is_far_half)
            return false;
    for (Eigen::Index v = 0; v < lattices[0]->levels.size(); ++v) {
        std::size_t kind = 0;
        for (std::size_t axis = 0; axis < 3; ++axis)
            kind |= to_size(lattices[axis]->levels[v] & 1) << axis;
        kinds[kind] += 1.0;
        all += 1.0;
    }
    for (std::size_t even = 0; even < 8; ++even) // the parities of voxels are not known
        if (kinds[even ^ 1U] + kinds[even ^ 2U] + kinds[even ^ 4U] >= share * all)
            return true;
    return false;
}

/// Whether edges are about as long as the steps, and still none has lost its length.
bool are_short_and_whole(const Faces& faces, const std::array<std::optional<Lattice>, 3>& lattices)
{
    constexpr double share = 0.6;
    constexpr int least_sides = 400;    // every edge is met twice
    constexpr double most_ratio = 12.0; // of slices to pixels; heights have finer steps
    int within = 0;
    int all = 0;
    double least = std::numeric_limits<double>::infinity();
    double most_step = 0.0;
    for (const auto& lattice : lattices) {
        if (!lattice || lattice->is_far_half)
            return false;
        least = std::min(least, lattice->step);
        most_step = std::max(most_step, lattice->step);
    }
    if (most_step > most_ratio * least)
        return false;
    for (const auto& face : faces.rowwise())
        for (int c = 0; c < 3; ++c) {
            int most = 0;
            for (const auto& lattice : lattices)
                most = std::max(
                    most, std::abs(lattice->levels[face[c]] - lattice->levels[face[(c + 1) % 3]]));
            if (most == 0)
                return false;
            ++all;
            within += most == 1 ? 1 : 0;
        }
    return within >= least_sides && within >= share * all;
}

/// Where a vertex is against the surface around it.
struct Offset
{
    double distance = 0.0; ///< [length] From a quadric through two rings.
    double variance = 1.0; ///< Of that, if each point has a variance of one across the surface.
    Eigen::Vector3d normal;
    Eigen::Vector3d extent; ///< [length] Of the rings along the axes.
};

/// Of some vertices, evenly drawn.
std::vector<Offset> offsets(const Faces& faces, const Points& points)
{
    constexpr Eigen::Index most = 2000;
    constexpr std::size_t least_around = 10; // six coefficients
    constexpr double flat = 1e-9;            // two rings on a conic tell no quadric
    std::vector<std::vector<int>> around(to_size(points.rows()));
    Points normals = Points::Zero(points.rows(), 3);
    for (const auto& face : faces.rowwise()) {
        const Eigen::Vector3d a = points.row(face[0]);
        const Eigen::Vector3d b = points.row(face[1]);
        const Eigen::Vector3d c = points.row(face[2]);
        const Eigen::Vector3d normal = (b - a).cross(c - a);
        for (int k = 0; k < 3; ++k) {
            around[to_size(face[k])].push_back(face[(k + 1) % 3]);
            normals.row(face[k]) += normal.transpose();
        }
    }
    std::vector<Offset> result;
    const Eigen::Index count = std::min(points.rows(), most);
    for (Eigen::Index k = 0; k < count; ++k) {
        const auto v = static_cast<int>(k * points.rows() / count);
        std::vector<int> rings;
        for (const int first : around[to_size(v)]) {
            rings.push_back(first);
            rings.insert(rings.end(), around[to_size(first)].begin(), around[to_size(first)].end());
        }
        std::sort(rings.begin(), rings.end());
        rings.erase(std::unique(rings.begin(), rings.end()), rings.end());
        std::erase(rings, v);
        Eigen::Vector3d normal = normals.row(v).transpose();
        if (rings.size() < least_around || !(normal.norm() > 0.0))
            continue;
        normal.normalize();
        const Eigen::Vector3d u = normal.unitOrthogonal();
        const Eigen::Vector3d w = normal.cross(u);
        Points from = points(rings, Eigen::all);
        from.rowwise() -= points.row(v);
        const double size = from.rowwise().norm().mean();
        if (!(size > 0.0))
            continue;
        const Eigen::VectorXd x = from * u / size;
        const Eigen::VectorXd y = from * w / size;
        Eigen::Matrix<double, Eigen::Dynamic, 6> terms(from.rows(), 6);
        terms << Eigen::VectorXd::Ones(from.rows()), x, y, x.cwiseProduct(x), x.cwiseProduct(y),
            y.cwiseProduct(y);
        Eigen::Matrix<double, 6, 6> squares = terms.transpose() * terms;
        squares.diagonal().array() += flat * squares.trace();
        const Eigen::VectorXd weights = // that give the height at the vertex
            terms * squares.ldlt().solve(Eigen::Matrix<double, 6, 1>::Unit(0));
        result.push_back({std::abs(weights.dot(from * normal)), 1.0 + weights.squaredNorm(), normal,
                          (from.colwise().maxCoeff() - from.colwise().minCoeff()).transpose()});
    }
    return result;
}

/// The median distance of vertices from the surface around them, by the standard deviation that rounding along an axis leaves;
/// negative where too few would tell. Of a plateau, which may be all of one step, nothing is known.
double roughness(const std::vector<Offset>& all, Eigen::Index axis, double step)
{
    constexpr std::size_t least_count = 10;
    constexpr double least_across = 0.25;
    constexpr double least_steps = 1.5;
    std::vector<double> ratios;
    for (const Offset& offset : all)
        if (const double across = std::abs(offset.normal[axis]);
            across >= least_across && offset.extent[axis] > least_steps * step)
            ratios.push_back(offset.distance / (across * step * std::sqrt(offset.variance / 12.0)));
    return ratios.size() < least_count ? -1.0 : median(std::move(ratios));
}

} // namespace

std::optional<Lattice> find_lattice(const Eigen::VectorXd& coordinates, double least)
{
    constexpr int least_levels = 4;
    constexpr int least_of_half = 20;
    std::vector<Eigen::Index> all;
    std::vector<Eigen::Index> far;
    const double half = 0.5 * coordinates.cwiseAbs().maxCoeff();
    for (Eigen::Index v = 0; v < coordinates.size(); ++v) {
        all.push_back(v);
        if (std::abs(coordinates[v]) >= half)
            far.push_back(v);
    }
    std::optional<Lattice> found = lattice_of(coordinates, all, least, least_levels);
    if (!found && std::ssize(far) >= least_of_half) {
        found = lattice_of(coordinates, far, least, least_of_half);
        if (found)
            found->is_far_half = true;
    }
    return found;
}

std::array<bool, 3> are_meant(const Faces& faces, const Points& points,
                              const std::array<std::optional<Lattice>, 3>& lattices)
{
    constexpr double exact = 0.2; // of what rounding leaves, of which the median is 0.67
    constexpr double uneven = 3.0;
    std::array<int, 3> kinds{};
    for (std::size_t axis = 0; axis < 3; ++axis)
        if (lattices[axis])
            kinds[axis] = kind_of(faces, *lattices[axis]);
    if (is_made_of_planes(faces, points))
        return {true, true, true};
    std::array<bool, 3> is_step{};
    for (std::size_t axis = 0; axis < 3; ++axis)
        is_step[axis] =
            kinds[axis] == 1 && kinds[(axis + 1) % 3] == 0 && kinds[(axis + 2) % 3] == 0 &&
            is_terraced(faces, points, *lattices[axis], static_cast<Eigen::Index>(axis));
    const bool halfway = are_halfway(lattices);
    // Heights over a raster are asked alone.
    const bool all =
        std::count(kinds.begin(), kinds.end(), 1) < 2 && are_short_and_whole(faces, lattices);
    std::array<bool, 3> is_regular{};
    bool asks_surface = false;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        const bool beside = kinds[(axis + 1) % 3] == 1 || kinds[(axis + 2) % 3] == 1;
        is_regular[axis] = !is_step[axis] &&
                           (all || kinds[axis] == 1 || (kinds[axis] == 2 && (beside || halfway)));
        asks_surface = asks_surface || (lattices[axis] && !is_regular[axis] && !is_step[axis]);
    }
    if (!asks_surface)
        return is_regular;
    const std::vector<Offset> surface = offsets(faces, points);
    std::array<bool, 3> meant = is_regular;
    for (std::size_t axis = 0; axis < 3; ++axis) {
        if (!lattices[axis] || is_regular[axis] || is_step[axis])
            continue;
        const double rough =
            roughness(surface, static_cast<Eigen::Index>(axis), lattices[axis]->step);
        const bool is_field = is_regular[(axis + 1) % 3] && is_regular[(axis + 2) % 3];
        meant[axis] = (rough >= 0.0 && rough < exact) || (is_field && rough >= uneven);
    }
    return meant;
}

} // namespace shape::internal
