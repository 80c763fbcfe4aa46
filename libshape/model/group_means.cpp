// SPDX-License-Identifier: MIT

#include "libshape/model/group_means.h"

#include <utility>

#include "libshape/base/error.h"
#include "libshape/base/format.h"
#include "libshape/statistics/group_fit.h"
#include "libshape/statistics/inner_products.h"

namespace shape {
using namespace internal;

GroupedShapes group_shapes(const Collection& collection, const Grouping& groups,
                           const SpaceOptions& options)
{
    return group_shapes(collection, groups, options, groups_of_one(groups.size()));
}

GroupedShapes group_shapes(const Collection& collection, const Grouping& groups,
                           const SpaceOptions& options, const Grouping& blocks,
                           const CovariatesOfSizes& covariates)
{
    for (const Grouping* grouping : {&groups, &blocks})
        if (grouping->group_of.size() != collection.size())
            throw InvalidInput(join("groups: the grouping is of ", grouping->size(),
                                    " meshes, the collection has ", collection.size()));
    (void)members(groups); // none is empty
    GroupedShapes result;
    result.space = make_space(collection, options);
    result.sizes = sizes(result.space, collection);
    const GroupFit fit(groups, blocks,
                       covariates ? covariates(result.sizes) : Eigen::MatrixXd(groups.size(), 0));
    result.covariate_means = fit.covariate_means();
    const Eigen::MatrixXd weights = fit.means().transpose();
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
    if (!shapes.means.row(group).allFinite())
        throw InvalidInput(join("mean shape: the mean of group ", group,
                                " cannot be adjusted for a covariate that does not vary within the "
                                "groups; leave that covariate out"));
    return decode(shapes.space, shapes.means.row(group), shapes.dihedral_angles.row(group),
                  shapes.mean_sizes[group]);
}

} // namespace shape
