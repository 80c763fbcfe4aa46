// SPDX-License-Identifier: MIT

#include "libshape/model/group_means.h"

#include <utility>

#include "libshape/base/error.h"
#include "libshape/base/format.h"
#include "libshape/statistics/inner_products.h"

namespace shape {
using namespace internal;

GroupedShapes group_shapes(const Collection& collection, const Grouping& groups,
                           const SpaceOptions& options)
{
    if (groups.group_of.size() != collection.size())
        throw InvalidInput(join("groups: the grouping is of ", groups.size(),
                                " meshes, the collection has ", collection.size()));
    const Eigen::MatrixXd indicator = indicators(groups);
    const Eigen::MatrixXd weights =
        indicator.colwise().sum().cwiseInverse().asDiagonal() * indicator.transpose();
    GroupedShapes result;
    result.space = make_space(collection, options);
    result.sizes = sizes(result.space, collection);
    result.mean_sizes = weights * result.sizes;
    RowMatrix coordinates = encode(result.space, collection);
    result.means = weights * coordinates;
    result.products = centred_inner_products(std::move(coordinates));
    result.dihedral_angles = weights * companions(result.space, collection);
    return result;
}

DecodedShape mean_shape(const GroupedShapes& shapes, int group)
{
    if (group < 0 || group >= shapes.means.rows())
        throw InvalidInput(
            join("mean shape: group is ", group, ", must be in [0, ", shapes.means.rows(), ")"));
    return decode(shapes.space, shapes.means.row(group), shapes.dihedral_angles.row(group),
                  shapes.mean_sizes[group]);
}

} // namespace shape
