// SPDX-License-Identifier: MIT

#include "libshape/linalg/block_products.h"

#include <cblas.h>

#include <algorithm>

#include "libshape/linalg/blas_turn.h"

extern "C" void openblas_set_num_threads(
    int); // cblas.h of OpenBLAS declares it, that of others not

namespace shape::internal {
namespace {

int stride(const ConstBlock& block)
{
    return static_cast<int>(std::max<Eigen::Index>(block.outerStride(), 1));
}

void multiply(CBLAS_TRANSPOSE how_a, CBLAS_TRANSPOSE how_b, Eigen::Index depth, const ConstBlock& a,
              const ConstBlock& b, Block c)
{
    static const bool is_alone = [] {
        openblas_set_num_threads(1); // bits must not depend on the machine's thread count
        return true;
    }();
    if (!is_alone || c.size() == 0 || depth == 0)
        return;
    const BlasTurn turn;
    cblas_dgemm(CblasRowMajor, how_a, how_b, static_cast<int>(c.rows()), static_cast<int>(c.cols()),
                static_cast<int>(depth), 1.0, a.data(), stride(a), b.data(), stride(b), 1.0,
                c.data(), static_cast<int>(std::max<Eigen::Index>(c.outerStride(), 1)));
}

} // namespace

void add_product(const ConstBlock& a, const ConstBlock& b, Block c)
{
    multiply(CblasNoTrans, CblasNoTrans, a.cols(), a, b, c);
}

void add_product_with_rows(const ConstBlock& a, const ConstBlock& b, Block c)
{
    multiply(CblasNoTrans, CblasTrans, a.cols(), a, b, c);
}

void add_product_of_columns(const ConstBlock& a, const ConstBlock& b, Block c)
{
    multiply(CblasTrans, CblasNoTrans, a.rows(), a, b, c);
}

} // namespace shape::internal
