// SPDX-License-Identifier: MIT

#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <filesystem>

#include "libshape/base/progress.h"
#include "libshape/edge_space/shape_space.h"
#include "libshape/mesh/mesh_stream.h"

namespace shape {

struct StreamedProductsOptions
{
    /// In which space meshes are compared.
    SpaceOptions space = {};
    /// At most this much memory is used [byte]; 0: a quarter of the machine's.
    std::uint64_t memory = 0;
    Progress progress = {}; ///< Called with kilobytes read, of the pass that its stage names.
    std::filesystem::path scratch = {}; ///< As of StreamOptions; changes no bit.
};

/// @throws InvalidInput naming the first field that breaks its rule.
void check(const StreamedProductsOptions& options);

/// Of meshes as points of a space all that tests, discriminants and regressions ask for.
struct StreamedProducts
{
    ShapeSpace space;
    Eigen::MatrixXd products; ///< N by N inner products about the mean.
    Eigen::VectorXd mean;     ///< D.
    Eigen::VectorXd sizes;    ///< N, see sizes() of shape_space.h [length].
    Points reference_points;  ///< The first mesh.
    int passes = 0;
};

/// centred_inner_products() of the meshes of a collection that need not fit into memory, to rounding.
/// @throws InvalidInput if there is no mesh, or as make_space() of streams; LimitExceeded if the products and
///     what is made of them, 32 N^2 bytes, exceed half of the memory (it says what would do); what reading
///     throws.
/// Cost: N^2 E / 2 multiplications and one pass with a scratch folder, else about N / (2 h) where h meshes
///     are held. Same bits for any memory and any thread count.
[[nodiscard]] StreamedProducts measure_products(const MeshStream& meshes,
                                                const StreamedProductsOptions& options);

} // namespace shape
