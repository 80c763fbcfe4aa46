// SPDX-License-Identifier: MIT

#include <cmath>
#include <numbers>

#include "libshape/synthetic/generators.h"

namespace shape::internal::synthetic {

Collection make_icosahedron(const SyntheticOptions&)
{
    // Two poles on the y axis and two rings of five; all on the unit sphere.
    const double height = 1.0 / std::sqrt(5.0);
    Points regular(12, 3);
    Faces faces(20, 3);
    regular.row(0) << 0.0, 1.0, 0.0;
    regular.row(11) << 0.0, -1.0, 0.0;
    for (int i = 0; i < 5; ++i) {
        const double upper = 2.0 * std::numbers::pi * i / 5.0;
        const double lower = upper + std::numbers::pi / 5.0;
        regular.row(1 + i) << 2.0 * height * std::sin(upper), height,
            2.0 * height * std::cos(upper);
        regular.row(6 + i) << 2.0 * height * std::sin(lower), -height,
            2.0 * height * std::cos(lower);
        const int next = (i + 1) % 5;
        faces.row(4 * i) << 0, 1 + i, 1 + next;
        faces.row(4 * i + 1) << 1 + i, 6 + i, 1 + next;
        faces.row(4 * i + 2) << 6 + i, 6 + next, 1 + next;
        faces.row(4 * i + 3) << 11, 6 + next, 6 + i;
    }
    // The top vertex mirrored at the plane of its neighbours keeps its five edges.
    Points pushed_in = regular;
    pushed_in(0, 1) = 2.0 * height - 1.0;
    Members members(faces, {"top"});
    members.add("icosahedron_convex", regular, {"out"});
    members.add("icosahedron_pushed", pushed_in, {"in"});
    return members.take();
}

} // namespace shape::internal::synthetic
