// SPDX-License-Identifier: MIT

#include "libshape/mesh/face_crossings.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

#include "libshape/base/threads.h"

namespace shape::internal {
namespace {

std::size_t index(int i)
{
    return static_cast<std::size_t>(i);
}

struct Box
{
    Eigen::Array3d low = Eigen::Array3d::Constant(std::numeric_limits<double>::infinity());
    Eigen::Array3d high = -low;

    void add(const Eigen::Array3d& point)
    {
        low = low.min(point);
        high = high.max(point);
    }
    void add(const Box& box)
    {
        low = low.min(box.low);
        high = high.max(box.high);
    }
    [[nodiscard]] bool meets(const Box& box) const
    {
        return (low <= box.high).all() && (box.low <= high).all();
    }
};

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

using Corners = std::array<const double*, 3>;

/// Whether the side from p to q crosses the inside of a triangle. One from a corner of it does not.
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

bool cross(const Corners& s, const Corners& t)
{
    for (std::size_t c = 0; c < 3; ++c)
        if (crosses(s[c], s[(c + 1) % 3], t) || crosses(t[c], t[(c + 1) % 3], s))
            return true;
    return false;
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

FaceTree::FaceTree(const Topology& topology, const Points& reference)
    : topology_(topology), order_(index(topology.face_count()))
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
            nodes_[index(parent)].right = node;
        if (last - first == 1)
            continue;
        Box box;
        for (int i = first; i < last; ++i)
            box.add(centres[index(order_[index(i)])]);
        int axis = 0;
        (box.high - box.low).maxCoeff(&axis);
        const int middle = (first + last) / 2;
        std::nth_element(order_.begin() + first, order_.begin() + middle, order_.begin() + last,
                         [&](int a, int b) {
                             return std::pair(centres[index(a)][axis], a) <
                                    std::pair(centres[index(b)][axis], b);
                         });
        ranges.push_back({middle, last, node});
        ranges.push_back({first, middle, -1});
    }
}

std::vector<FacePair> FaceTree::crossings(const Points& points) const
{
    std::vector<Box> boxes(nodes_.size());
    for (std::size_t n = nodes_.size(); n-- > 0;) { // children come after their parents
        if (nodes_[n].right == 0)
            for (const int v : topology_.faces().row(order_[index(nodes_[n].first)]))
                boxes[n].add(points.row(v).transpose().array());
        else {
            boxes[n].add(boxes[n + 1]);
            boxes[n].add(boxes[index(nodes_[n].right)]);
        }
    }
    const auto corners = [&](int face) {
        const int* const v = topology_.faces().data() + 3 * face;
        return Corners{points.data() + 3 * v[0], points.data() + 3 * v[1],
                       points.data() + 3 * v[2]};
    };
    // Each face against those after it in the order of the tree.
    constexpr std::size_t grain = 256;
    std::vector<std::vector<FacePair>> found((order_.size() + grain - 1) / grain);
    std::vector<std::size_t> leaves(order_.size());
    for (std::size_t n = 0; n < nodes_.size(); ++n)
        if (nodes_[n].right == 0)
            leaves[index(nodes_[n].first)] = n;
    parallel_for(order_.size(), grain, [&](std::size_t begin, std::size_t end) {
        std::vector<std::size_t> stack;
        for (std::size_t i = begin; i < end; ++i) {
            const int face = order_[i];
            const Box& box = boxes[leaves[i]];
            const Corners here = corners(face);
            stack.assign(1, 0);
            while (!stack.empty()) {
                const std::size_t n = stack.back();
                stack.pop_back();
                const Node& node = nodes_[n];
                if (index(node.last) <= i + 1 || !box.meets(boxes[n]))
                    continue;
                if (node.right != 0) {
                    stack.push_back(index(node.right));
                    stack.push_back(n + 1);
                } else if (const int other = order_[index(node.first)];
                           cross(here, corners(other))) {
                    found[begin / grain].push_back({std::min(face, other), std::max(face, other)});
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
