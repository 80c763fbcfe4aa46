// SPDX-License-Identifier: MIT

#include <algorithm>
#include <cmath>
#include <numbers>

#include "libshape/base/format.h"
#include "libshape/base/random.h"
#include "libshape/synthetic/generators.h"

namespace shape::internal::synthetic {

Collection make_torus(const SyntheticOptions& options)
{
    using std::numbers::pi;
    const double minor = 0.5; // radius of the tube; that of its axis is 1
    const double tallest = 4.0;
    const int around =
        std::max(5, static_cast<int>(std::lround(std::sqrt(options.vertices * minor))));
    const int along = std::max(5, static_cast<int>(std::lround(1.0 * options.vertices / around)));

    Random random(options.seed);
    Faces faces(2 * along * around, 3);
    Points torus(along * around, 3);
    for (int i = 0; i < along; ++i)
        for (int j = 0; j < around; ++j) {
            const double u = 2.0 * pi * i / along;
            const double v = 2.0 * pi * j / around;
            const double r = 1.0 + minor * std::cos(v);
            torus.row(i * around + j) << r * std::sin(u), minor * std::sin(v), r * std::cos(u);
            const int p = i * around + j;
            const int q = (i + 1) % along * around + j;
            const int s = (i + 1) % along * around + (j + 1) % around;
            const int t = i * around + (j + 1) % around;
            const int f = 2 * p;
            if (random.index(2) == 0) {
                faces.row(f) << p, q, s;
                faces.row(f + 1) << p, s, t;
            } else {
                faces.row(f) << p, q, t;
                faces.row(f + 1) << q, s, t;
            }
        }
    Members members(faces, {"stretch"});
    for (int k = 0; k < options.count; ++k) {
        const double stretch = 1.0 + (tallest - 1.0) * k / (options.count - 1);
        std::string name = k == 0 ? "torus" : "barrel";
        if (k > 0 && k + 1 < options.count)
            name = join("torus_", padded(k, 4));
        members.add(std::move(name), torus * Eigen::Vector3d(1.0, stretch, 1.0).asDiagonal(),
                    {join(stretch)});
    }
    return members.take();
}

} // namespace shape::internal::synthetic
