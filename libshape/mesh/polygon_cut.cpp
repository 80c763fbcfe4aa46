// SPDX-License-Identifier: MIT

#include "libshape/mesh/polygon_cut.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <limits>

#include "libshape/base/to_size.h"

namespace shape::internal {
namespace {

constexpr double no_area = 1e-12; ///< Of the polygon's.

Eigen::RowVector3d normal_of(const Points& corners, const CutTriangle& triangle)
{
    const Eigen::RowVector3d at = corners.row(triangle[0]);
    return (corners.row(triangle[1]) - at).cross(corners.row(triangle[2]) - at);
}

Eigen::RowVector3d newell_normal(const Points& corners)
{
    Eigen::RowVector3d sum = Eigen::RowVector3d::Zero();
    for (int i = 2; i < corners.rows(); ++i)
        sum += normal_of(corners, {0, i - 1, i});
    return sum;
}

bool lies_against(const Eigen::RowVector3d& own, const Eigen::RowVector3d& of_polygon)
{
    return !(own.dot(of_polygon) > no_area * of_polygon.squaredNorm());
}

std::vector<CutTriangle> fan(int corner_count)
{
    std::vector<CutTriangle> triangles;
    for (int i = 2; i < corner_count; ++i)
        triangles.push_back({0, i - 1, i});
    return triangles;
}

/// The polygon seen from its front, counter-clockwise, and what of it is left to cut.
class EarCut
{
public:
    EarCut(const Points& corners, const Eigen::RowVector3d& normal)
    {
        const Eigen::Vector3d front = normal.transpose().normalized();
        const Eigen::Vector3d across = front.unitOrthogonal();
        const Eigen::Vector3d up = front.cross(across);
        for (const auto& corner : corners.rowwise()) {
            const Eigen::RowVector3d from_first = corner - corners.row(0);
            at_.emplace_back(from_first.dot(across), from_first.dot(up));
        }
        for (std::size_t i = 0; i < at_.size(); ++i)
            left_.push_back(static_cast<int>(i));
        least_area_ = no_area * normal.norm();
    }

    std::optional<std::vector<CutTriangle>> cut()
    {
        std::vector<CutTriangle> triangles;
        measure_all();
        bool is_fresh = true;
        while (left_.size() > 3) {
            const auto best =
                to_size(std::max_element(worth_.begin(), worth_.end()) - worth_.begin());
            if (worth_[best] < 0.0) {
                if (is_fresh)
                    return std::nullopt;
                measure_all(); // what was in the way may be cut off by now
                is_fresh = true;
                continue;
            }
            triangles.push_back(triangle_at(best));
            left_.erase(left_.begin() + static_cast<std::ptrdiff_t>(best));
            worth_.erase(worth_.begin() + static_cast<std::ptrdiff_t>(best));
            for (const std::size_t neighbour : {best % left_.size(), before(best % left_.size())})
                worth_[neighbour] = worth_of_ear(neighbour);
            is_fresh = false;
        }
        triangles.push_back({left_[0], left_[1], left_[2]});
        if (area(triangles.back()) <= least_area_)
            return std::nullopt;
        return triangles;
    }

private:
    using Point = Eigen::Vector2d;

    [[nodiscard]] std::size_t before(std::size_t i) const
    {
        return (i + left_.size() - 1) % left_.size();
    }
    [[nodiscard]] CutTriangle triangle_at(std::size_t i) const
    {
        return {left_[before(i)], left_[i], left_[(i + 1) % left_.size()]};
    }
    static double area(const Point& a, const Point& b, const Point& c) // twice
    {
        return (b.x() - a.x()) * (c.y() - a.y()) - (b.y() - a.y()) * (c.x() - a.x());
    }
    [[nodiscard]] double area(const CutTriangle& t) const
    {
        return area(at_[to_size(t[0])], at_[to_size(t[1])], at_[to_size(t[2])]);
    }

    /// Whether a corner lies in the triangle or on its sides, but not on a corner of it.
    [[nodiscard]] bool is_in(const Point& point, const CutTriangle& triangle) const
    {
        for (std::size_t c = 0; c < 3; ++c) {
            const Point& from = at_[to_size(triangle[c])];
            const Point& to = at_[to_size(triangle[(c + 1) % 3])];
            if (point == from || area(from, to, point) < -least_area_)
                return false;
        }
        return true;
    }

    /// Area for the longest side squared; -1 of what is no ear: turned inwards or flat, or with a corner inside.
    [[nodiscard]] double worth_of_ear(std::size_t i) const
    {
        const CutTriangle triangle = triangle_at(i);
        const double size = area(triangle);
        if (size <= least_area_)
            return -1.0;
        double longest = 0.0;
        for (std::size_t c = 0; c < 3; ++c)
            longest = std::max(
                longest,
                (at_[to_size(triangle[c])] - at_[to_size(triangle[(c + 1) % 3])]).squaredNorm());
        // If any corner lies inside, one that does not turn outwards does.
        for (std::size_t k = 0; k < left_.size(); ++k)
            if (area(triangle_at(k)) <= least_area_ && is_in(at_[to_size(left_[k])], triangle))
                return -1.0;
        return size / longest;
    }

    void measure_all()
    {
        worth_.clear();
        for (std::size_t i = 0; i < left_.size(); ++i)
            worth_.push_back(worth_of_ear(i));
    }

    std::vector<Point> at_;
    std::vector<int> left_;
    std::vector<double> worth_; ///< Of the ear at each corner that is left.
    double least_area_ = 0.0;
};

} // namespace

bool folds_over(const Points& corners, const std::vector<CutTriangle>& cut)
{
    const Eigen::RowVector3d normal = newell_normal(corners);
    return std::ranges::any_of(cut, [&](const CutTriangle& triangle) {
        return lies_against(normal_of(corners, triangle), normal);
    });
}

bool fan_folds_over(const Points& corners)
{
    const Eigen::RowVector3d normal = newell_normal(corners);
    for (int i = 2; i < corners.rows(); ++i)
        if (lies_against(normal_of(corners, {0, i - 1, i}), normal))
            return true;
    return false;
}

std::optional<std::vector<CutTriangle>> cut_polygon(const Points& corners)
{
    std::vector<CutTriangle> usual = fan(static_cast<int>(corners.rows()));
    if (corners.rows() == 3 || !fan_folds_over(corners))
        return usual;
    // Powers of lengths beyond all units would leave the range of numbers.
    const double size = (corners.rowwise() - corners.row(0)).cwiseAbs().maxCoeff();
    if (!(size > 0.0))
        return usual;
    const Points shape = (corners.rowwise() - corners.row(0)) / size;
    if (!fan_folds_over(shape))
        return usual;
    const Eigen::RowVector3d normal = newell_normal(shape);
    double areas = 0.0;
    bool is_against = false;
    for (const CutTriangle& triangle : usual) {
        const Eigen::RowVector3d own = normal_of(shape, triangle);
        areas += own.norm();
        is_against = is_against || own.dot(normal) < -no_area * normal.squaredNorm();
    }
    if (areas <= no_area)
        return usual;
    if (normal.norm() > no_area * areas)
        if (auto ears = EarCut(shape, normal).cut())
            return ears;
    // Corners that lie on one another or in a line leave triangles without area, which find_defects() names.
    if (!is_against && normal.norm() > no_area * areas)
        return usual;
    return std::nullopt;
}

} // namespace shape::internal
