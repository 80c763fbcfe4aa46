// SPDX-License-Identifier: MIT

#include "libshape/registration/closest_points.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <nanoflann.hpp>
#include <vector>

#include "libshape/base/error.h"
#include "libshape/base/format.h"
#include "libshape/base/to_size.h"
#include "libshape/mesh/nearest_in_triangle.h"

namespace shape::internal {

using Eigen::Vector3d;

namespace {

/// A point on a face, for the tree.
struct Sample
{
    Vector3d position;
    int face;
    double radius; // of its part of the face
};

/// Distance from the middle of a triangle to its farthest corner.
double radius(const Vector3d& a, const Vector3d& b, const Vector3d& c)
{
    const Vector3d m = (a + b + c) / 3.0;
    return std::sqrt(
        std::max({(a - m).squaredNorm(), (b - m).squaredNorm(), (c - m).squaredNorm()}));
}

/// Middles of a triangle or, where it reaches farther than `cover`, of its four quarters, and so on.
void add_samples(const Vector3d& a, const Vector3d& b, const Vector3d& c, int face, double cover,
                 std::vector<Sample>& samples)
{
    if (const double reach = radius(a, b, c); reach <= cover) {
        samples.push_back({(a + b + c) / 3.0, face, reach});
        return;
    }
    const Vector3d ab = 0.5 * (a + b), bc = 0.5 * (b + c), ca = 0.5 * (c + a);
    add_samples(a, ab, ca, face, cover, samples);
    add_samples(ab, b, bc, face, cover, samples);
    add_samples(ca, bc, c, face, cover, samples);
    add_samples(ab, bc, ca, face, cover, samples);
}

/// What nanoflann asks of a set of points.
struct SampleSet
{
    std::vector<Sample> samples;

    [[nodiscard]] std::size_t kdtree_get_point_count() const { return samples.size(); }
    [[nodiscard]] double kdtree_get_pt(std::size_t i, std::size_t axis) const
    {
        return samples[i].position[static_cast<Eigen::Index>(axis)];
    }
    template <class Box>
    bool kdtree_get_bbox(Box& /*box*/) const
    {
        return false;
    }
};

using SampleTree =
    nanoflann::KDTreeSingleIndexAdaptor<nanoflann::L2_Simple_Adaptor<double, SampleSet>, SampleSet,
                                        3, std::uint32_t>;

} // namespace

struct ClosestPoints::Tree
{
    Points points;
    Faces faces;
    Points normals; // of the faces, unit length; 0 of a face without area
    SampleSet set;
    double cover = 0.0;
    std::unique_ptr<SampleTree> index;

    [[nodiscard]] Vector3d corner(int f, int k) const { return points.row(faces(f, k)); }
};

namespace {

Points unit_normals(const Points& points, const Faces& faces)
{
    Points normals = Points::Zero(faces.rows(), 3);
    for (Eigen::Index f = 0; f < faces.rows(); ++f) {
        if (faces.row(f).minCoeff() < 0 || faces.row(f).maxCoeff() >= points.rows())
            continue; // the constructor says so
        const Vector3d a = points.row(faces(f, 0)), b = points.row(faces(f, 1)),
                       c = points.row(faces(f, 2));
        normals.row(f) = (b - a).cross(c - a).stableNormalized();
    }
    return normals;
}

/// What a search has found; nanoflann hands it every sample whose squared distance is below worstDist().
template <class Tree>
class Nearest
{
public:
    Nearest(const Tree& tree, const Vector3d& point, const NearestRule& rule)
        : tree_(tree), point_(point), rule_(rule), best_(rule.within * rule.within)
    {
        set_reach();
        if (rule_.guess >= 0)
            look_at(rule_.guess);
    }

    // NOLINTBEGIN(readability-identifier-naming): the names are nanoflann's.
    [[nodiscard]] std::size_t size() const { return found_.face >= 0 ? 1 : 0; }
    [[nodiscard]] bool full() const { return true; }
    [[nodiscard]] double worstDist() const { return reach_; }
    bool addPoint(double square_of_sample, std::uint32_t sample)
    // NOLINTEND(readability-identifier-naming)
    {
        const int f = tree_.set.samples[sample].face;
        if (square_of_sample > reach_ || f == found_.face)
            return true;
        const double nearest = best_distance_ + tree_.set.samples[sample].radius;
        if (square_of_sample > nearest * nearest * (1.0 + 1e-12))
            return true; // no point of this part of the face is as near
        look_at(f);
        return true;
    }

    [[nodiscard]] SurfacePoint result() const
    {
        SurfacePoint point = found_;
        if (point.face >= 0)
            point.distance = (point.position - point_).norm();
        return point;
    }

private:
    void look_at(int f)
    {
        double penalty = 0.0;
        if (rule_.least_cosine > -1.0 || rule_.normal_weight > 0.0) {
            const double cosine = rule_.normal.dot(tree_.normals.row(f));
            if (cosine < rule_.least_cosine)
                return;
            penalty = 2.0 * rule_.normal_weight * rule_.normal_weight * (1.0 - cosine);
            if (penalty > best_)
                return;
        }
        const Vector3d a = tree_.corner(f, 0), b = tree_.corner(f, 1), c = tree_.corner(f, 2);
        const Vector3d weights = nearest_in_triangle(point_, a, b, c);
        const Vector3d position = weights[0] * a + weights[1] * b + weights[2] * c;
        const double square = (position - point_).squaredNorm() + penalty;
        if (square < best_ || (square == best_ && (found_.face < 0 || f < found_.face))) {
            best_ = square;
            found_ = {f, weights, position, 0.0};
            set_reach();
        }
    }

    void set_reach()
    {
        best_distance_ = std::sqrt(best_);
        const double reach = best_distance_ + tree_.cover;
        reach_ = reach * reach * (1.0 + 1e-12);
    }

    const Tree& tree_;
    Vector3d point_;
    const NearestRule& rule_;
    double best_;
    double best_distance_ = 0.0;
    double reach_ = 0.0;
    SurfacePoint found_;
};

} // namespace

ClosestPoints::ClosestPoints(const Points& points, const Faces& faces)
    : ClosestPoints(points, faces, unit_normals(points, faces))
{
}

ClosestPoints::ClosestPoints(const Points& points, const Faces& faces, const Points& normals)
    : tree_(std::make_unique<Tree>())
{
    if (faces.rows() == 0)
        throw InvalidInput("closest points: there is no face");
    if (!points.allFinite())
        throw InvalidInput("closest points: a coordinate is not finite");
    if (faces.minCoeff() < 0 || faces.maxCoeff() >= points.rows())
        throw InvalidInput(
            join("closest points: a face names a vertex that is not among the ", points.rows()));
    Tree& t = *tree_;
    t.points = points;
    t.faces = faces;
    t.normals = normals;
    std::vector<double> radii(to_size(faces.rows()));
    for (int f = 0; f < faces.rows(); ++f) {
        const Vector3d a = t.corner(f, 0), b = t.corner(f, 1), c = t.corner(f, 2);
        radii[to_size(f)] = radius(a, b, c);
    }
    // A search looks cover() too far: faces much larger than the others are cut, as long as that does not
    // make more than a few times as many samples.
    std::vector<double> sorted = radii;
    std::nth_element(sorted.begin(), sorted.begin() + std::ssize(sorted) * 9 / 10, sorted.end());
    const double usual = 1.5 * sorted[sorted.size() * 9 / 10];
    const double largest = *std::max_element(radii.begin(), radii.end());
    double cover = usual > 0.0 ? std::min(usual, largest) : largest;
    const auto samples_of = [&](double of_cover) {
        double count = 0.0;
        for (const double r : radii)
            count += r > of_cover ? 4.0 * (r / of_cover) * (r / of_cover) : 1.0;
        return count;
    };
    while (samples_of(cover) > 4.0 * static_cast<double>(radii.size()) + 1000.0)
        cover *= 1.5;
    t.cover = cover;
    for (int f = 0; f < faces.rows(); ++f)
        add_samples(t.corner(f, 0), t.corner(f, 1), t.corner(f, 2), f, cover, t.set.samples);
    t.index = std::make_unique<SampleTree>(3, t.set, nanoflann::KDTreeSingleIndexAdaptorParams(8));
}

ClosestPoints::~ClosestPoints() = default;
ClosestPoints::ClosestPoints(ClosestPoints&&) noexcept = default;
ClosestPoints& ClosestPoints::operator=(ClosestPoints&&) noexcept = default;

SurfacePoint ClosestPoints::nearest(const Vector3d& point, const NearestRule& rule) const
{
    Nearest<Tree> nearest(*tree_, point, rule);
    tree_->index->findNeighbors(nearest, point.data(), nanoflann::SearchParams());
    return nearest.result();
}

Vector3d ClosestPoints::near_point(const Vector3d& point) const
{
    std::uint32_t sample = 0;
    double square = 0.0;
    tree_->index->knnSearch(point.data(), 1, &sample, &square);
    return tree_->set.samples[sample].position;
}

double ClosestPoints::cover() const
{
    return tree_->cover;
}

} // namespace shape::internal
