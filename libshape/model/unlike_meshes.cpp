// SPDX-License-Identifier: MIT

#include "libshape/model/unlike_meshes.h"

#include "libshape/base/to_size.h"
#include "libshape/mesh/handedness.h"

namespace shape::internal {

RowMatrix unlike_meshes(const ShapeModel& model, const Collection& meshes,
                        const Eigen::VectorXd& sizes)
{
    constexpr double far = 5.0; // as odd_sizes() has it
    const double smallest = model.sizes.minCoeff(), largest = model.sizes.maxCoeff();
    RowMatrix marks = RowMatrix::Zero(sizes.size(), 3);
    for (Eigen::Index i = 0; i < sizes.size(); ++i) {
        const bool is_mirrored =
            is_mirror_image(model.topology, meshes.points[to_size(i)], model.reference_points);
        marks.row(i) << (is_mirrored ? 1.0 : 0.0), (sizes[i] > far * largest ? 1.0 : 0.0),
            (far * sizes[i] < smallest ? 1.0 : 0.0);
    }
    return marks;
}

} // namespace shape::internal
