// SPDX-License-Identifier: MIT

#include "libshape/mesh/face_crossings.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <numeric>
#include <span>
#include <utility>

#include "libshape/base/threads.h"
#include "libshape/base/to_size.h"
#include "libshape/base/vectorised.h"

namespace shape::internal {
namespace {

/// In single precision, made larger by what that rounds.
struct Box
{
    Eigen::Array3f low = Eigen::Array3f::Constant(std::numeric_limits<float>::infinity());
    Eigen::Array3f high = -low;

    void add(const Eigen::Array3f& point)
    {
        low = low.min(point);
        high = high.max(point);
    }
    void add(const Box& box)
    {
        low = low.min(box.low);
        high = high.max(box.high);
    }
    void widen(float by)
    {
        low -= by;
        high += by;
    }
    [[nodiscard]] bool meets(const Box& box) const
    {
        return (low <= box.high).all() && (box.low <= high).all();
    }
};

/// Boxes of the faces of a leaf, side by side: one against all is a few vector instructions. Places
/// without a face meet nothing.
struct LeafBoxes
{
    static constexpr int places = FaceTree::leaf_size;
    std::array<std::array<float, places>, 3> low, high;

    LeafBoxes()
    {
        for (std::size_t axis = 0; axis < 3; ++axis) {
            low[axis].fill(std::numeric_limits<float>::infinity());
            high[axis].fill(-std::numeric_limits<float>::infinity());
        }
    }

    void set(std::size_t place, const Box& box)
    {
        for (std::size_t axis = 0; axis < 3; ++axis) {
            low[axis][place] = box.low[static_cast<Eigen::Index>(axis)];
            high[axis][place] = box.high[static_cast<Eigen::Index>(axis)];
        }
    }
    [[nodiscard]] Box get(std::size_t place) const
    {
        Box box;
        for (std::size_t axis = 0; axis < 3; ++axis) {
            box.low[static_cast<Eigen::Index>(axis)] = low[axis][place];
            box.high[static_cast<Eigen::Index>(axis)] = high[axis][place];
        }
        return box;
    }
};

/// Of every face in a leaf whether its box meets another:
///
///     meets[i] = low_i <= high and low <= high_i, in x, y and z.
///
/// In memory low and high are rows of 16 floats, one a coordinate (LeafBoxes), so that a comparison is of
/// 4 or 8 faces. The plain loop, which stops at the first coordinate that is apart, takes one face at a
/// time and mispredicts: hence & in the place of &&.
SHAPE_VECTORISED void meet(const LeafBoxes& boxes, const float* low, const float* high,
                           std::array<std::uint8_t, LeafBoxes::places>& meets)
{
    const auto overlap = [&](std::size_t axis, std::size_t i) {
        return static_cast<int>(boxes.low[axis][i] <= high[axis]) &
               static_cast<int>(low[axis] <= boxes.high[axis][i]);
    };
    for (std::size_t i = 0; i < meets.size(); ++i)
        meets[i] = static_cast<std::uint8_t>(overlap(0, i) & overlap(1, i) & overlap(2, i));
}

/// A sum of doubles without rounding: its parts do not overlap and grow in size.
class ExactSum
{
public:
    void add(double value)
    {
        std::size_t kept = 0;
        for (std::size_t i = 0; i < parts_.size(); ++i) {
            const double sum = value + parts_[i];
            const double moved = sum - value;
            const double lost = (value - (sum - moved)) + (parts_[i] - moved);
            if (lost != 0.0)
                parts_[kept++] = lost;
            value = sum;
        }
        parts_.resize(kept);
        parts_.push_back(value);
    }
    void add_product(double a, double b, double c)
    {
        const double ab = a * b;
        for (const double part : {std::fma(a, b, -ab), ab}) {
            const double product = part * c;
            add(std::fma(part, c, -product));
            add(product);
        }
    }
    [[nodiscard]] int sign() const
    {
        for (auto part = parts_.rbegin(); part != parts_.rend(); ++part)
            if (*part != 0.0)
                return *part > 0.0 ? 1 : -1;
        return 0;
    }

private:
    std::vector<double> parts_;
};

/// The determinant of four points is that of (a, 1), (b, 1), (c, 1), (d, 1), up to its sign.
int exact_side(const double* a, const double* b, const double* c, const double* d)
{
    ExactSum sum;
    const auto add_volume = [&](const double* p, const double* q, const double* r, double sign) {
        for (int i = 0; i < 3; ++i) {
            const int j = (i + 1) % 3;
            const int k = (i + 2) % 3;
            sum.add_product(sign * p[i], q[j], r[k]);
            sum.add_product(-sign * p[i], q[k], r[j]);
        }
    };
    add_volume(b, c, d, 1.0);
    add_volume(a, c, d, -1.0);
    add_volume(a, b, d, 1.0);
    add_volume(a, b, c, -1.0);
    return sum.sign();
}

/// Whether the corners of s are on both sides of the plane of t. If not, their insides do not meet: s
/// touches the plane with its rim alone, or lies in it.
bool straddles(const Corners& s, const Corners& t)
{
    int sides = 0; // bits: below, above
    for (const double* const corner : s)
        if (corner != t[0] && corner != t[1] && corner != t[2])
            sides |= 1 << (side_of_plane(t[0], t[1], t[2], corner) + 1);
    return (sides & 5) == 5;
}

bool cross(const Corners& s, const Corners& t)
{
    if (!straddles(s, t) || !straddles(t, s))
        return false;
    for (std::size_t c = 0; c < 3; ++c)
        if (crosses(s[c], s[(c + 1) % 3], t) || crosses(t[c], t[(c + 1) % 3], s))
            return true;
    return false;
}

/// The faces of a mesh as triangles in space.
struct Triangles
{
    const int* faces;
    const double* points;

    [[nodiscard]] Corners corners(int face) const
    {
        const int* const v = faces + 3 * face;
        return {points + 3 * v[0], points + 3 * v[1], points + 3 * v[2]};
    }
    /// Faces that share a side meet there alone, or lie in one plane.
    [[nodiscard]] bool share_a_side(int a, int b) const
    {
        int shared = 0;
        for (int i = 0; i < 3; ++i)
            for (int j = 0; j < 3; ++j)
                shared += faces[3 * a + i] == faces[3 * b + j] ? 1 : 0;
        return shared >= 2;
    }
};

/// A leaf of the tree in one mesh.
struct Leaf
{
    std::span<const int> faces;
    LeafBoxes boxes; ///< Of the faces.
    Box bounds;      ///< Of all of them.
};

/// Finds the boxes of a leaf.
/// @param rounding  Boxes are made larger by this [length].
void measure(Leaf& leaf, const Triangles& mesh, float rounding)
{
    for (std::size_t i = 0; i < leaf.faces.size(); ++i) {
        Box box;
        for (const double* const corner : mesh.corners(leaf.faces[i]))
            box.add(Eigen::Map<const Eigen::Array3d>(corner).cast<float>());
        box.widen(rounding);
        leaf.boxes.set(i, box);
        leaf.bounds.add(box);
    }
}

/// Adds the pairs that cross of a face of one leaf and a face of another, or of the faces of one.
void add_crossings(const Triangles& mesh, const Leaf& one, const Leaf& other,
                   std::vector<FacePair>& found)
{
    std::array<std::uint8_t, LeafBoxes::places> meets{};
    for (std::size_t i = 0; i < one.faces.size(); ++i) {
        const Box box = one.boxes.get(i);
        if (!box.meets(other.bounds))
            continue;
        meet(other.boxes, box.low.data(), box.high.data(), meets);
        const int face = one.faces[i];
        for (std::size_t j = &one == &other ? i + 1 : 0; j < other.faces.size(); ++j)
            if (const int against = other.faces[j];
                meets[j] != 0 && !mesh.share_a_side(face, against) &&
                cross(mesh.corners(face), mesh.corners(against)))
                found.push_back({std::min(face, against), std::max(face, against)});
    }
}

} // namespace

int side_of_plane(const double* a, const double* b, const double* c, const double* d)
{
    const double bx = b[0] - a[0], by = b[1] - a[1], bz = b[2] - a[2];
    const double cx = c[0] - a[0], cy = c[1] - a[1], cz = c[2] - a[2];
    const double dx = d[0] - a[0], dy = d[1] - a[1], dz = d[2] - a[2];
    const double determinant =
        bx * (cy * dz - cz * dy) + by * (cz * dx - cx * dz) + bz * (cx * dy - cy * dx);
    const double size = std::abs(bx) * (std::abs(cy * dz) + std::abs(cz * dy)) +
                        std::abs(by) * (std::abs(cz * dx) + std::abs(cx * dz)) +
                        std::abs(bz) * (std::abs(cx * dy) + std::abs(cy * dx));
    constexpr double rounding = 1e-15; // Shewchuk's bound is 7.8e-16
    if (std::abs(determinant) > rounding * size)
        return determinant > 0.0 ? 1 : -1;
    return exact_side(a, b, c, d);
}

bool crosses(const double* p, const double* q, const Corners& t)
{
    for (const double* const corner : t)
        if (corner == p || corner == q)
            return false;
    const int side = side_of_plane(t[0], t[1], t[2], p);
    if (side == 0 || side_of_plane(t[0], t[1], t[2], q) != -side)
        return false;
    const int turn = side_of_plane(p, q, t[0], t[1]);
    return turn != 0 && side_of_plane(p, q, t[1], t[2]) == turn &&
           side_of_plane(p, q, t[2], t[0]) == turn;
}

FaceTree::FaceTree(const Topology& topology, const Points& reference)
    : topology_(topology), order_(to_size(topology.face_count()))
{
    std::iota(order_.begin(), order_.end(), 0);
    std::vector<Eigen::Array3d> centres;
    for (int f = 0; f < topology.face_count(); ++f)
        centres.emplace_back(
            reference(topology.faces().row(f), Eigen::all).colwise().sum().transpose());
    // Depth first; halves by the median along the longest side.
    std::vector<std::array<int, 3>> ranges{{0, topology.face_count(), -1}}; // and whose right child
    while (!ranges.empty()) {
        const auto [first, last, parent] = ranges.back();
        ranges.pop_back();
        const int node = static_cast<int>(nodes_.size());
        nodes_.push_back({first, last, 0});
        if (parent >= 0)
            nodes_[to_size(parent)].right = node;
        if (last - first <= leaf_size)
            continue;
        Eigen::Array3d low = centres[to_size(order_[to_size(first)])];
        Eigen::Array3d high = low;
        for (int i = first; i < last; ++i) {
            low = low.min(centres[to_size(order_[to_size(i)])]);
            high = high.max(centres[to_size(order_[to_size(i)])]);
        }
        int axis = 0;
        (high - low).maxCoeff(&axis);
        const int middle = (first + last) / 2;
        std::nth_element(order_.begin() + first, order_.begin() + middle, order_.begin() + last,
                         [&](int a, int b) {
                             return std::pair(centres[to_size(a)][axis], a) <
                                    std::pair(centres[to_size(b)][axis], b);
                         });
        ranges.push_back({middle, last, node});
        ranges.push_back({first, middle, -1});
    }
}

std::vector<FacePair> FaceTree::crossings(const Points& points) const
{
    const Triangles mesh{topology_.faces().data(), points.data()};
    std::vector<Box> boxes(nodes_.size());
    std::vector<Leaf> leaves;
    std::vector<std::size_t> nodes;                // of the leaves
    std::vector<std::size_t> ranks(nodes_.size()); // of nodes among leaves
    for (std::size_t n = 0; n < nodes_.size(); ++n)
        if (const Node& node = nodes_[n]; node.right == 0) {
            ranks[n] = leaves.size();
            nodes.push_back(n);
            leaves.push_back(
                {std::span(order_).subspan(to_size(node.first), to_size(node.last - node.first)),
                 {},
                 {}});
        }
    // Of the largest coordinate: single precision rounds a coordinate by 6e-8 of it, and the bound of the
    // box once more when it is moved.
    const auto rounding = static_cast<float>(2e-7 * points.cwiseAbs().maxCoeff());
    parallel_for(leaves.size(), 64, [&](std::size_t begin, std::size_t end) {
        for (std::size_t k = begin; k < end; ++k) {
            measure(leaves[k], mesh, rounding);
            boxes[nodes[k]] = leaves[k].bounds;
        }
    });
    for (std::size_t n = nodes_.size(); n-- > 0;) // children come after their parents
        if (nodes_[n].right != 0) {
            boxes[n].add(boxes[n + 1]);
            boxes[n].add(boxes[to_size(nodes_[n].right)]);
        }

    // Each leaf against itself and those after it in the order of the tree.
    constexpr std::size_t grain = 16;
    std::vector<std::vector<FacePair>> found((leaves.size() + grain - 1) / grain);
    parallel_for(leaves.size(), grain, [&](std::size_t begin, std::size_t end) {
        std::vector<std::size_t> stack;
        for (std::size_t k = begin; k < end; ++k) {
            stack.assign(1, 0);
            while (!stack.empty()) {
                const std::size_t n = stack.back();
                stack.pop_back();
                const Node& node = nodes_[n];
                if (node.last <= nodes_[nodes[k]].first || !leaves[k].bounds.meets(boxes[n]))
                    continue;
                if (node.right == 0) {
                    add_crossings(mesh, leaves[k], leaves[ranks[n]], found[begin / grain]);
                } else {
                    stack.push_back(to_size(node.right));
                    stack.push_back(n + 1);
                }
            }
        }
    });
    std::vector<FacePair> pairs;
    for (const std::vector<FacePair>& some : found)
        pairs.insert(pairs.end(), some.begin(), some.end());
    std::sort(pairs.begin(), pairs.end());
    return pairs;
}

} // namespace shape::internal
