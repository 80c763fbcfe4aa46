// SPDX-License-Identifier: MIT

#include "libshape/linalg/block_products.h"

#include <cblas.h>
#ifdef __x86_64__
#include <immintrin.h>
#endif

#include <algorithm>

#include "libshape/base/vectorised.h"
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

// Of few long rows BLAS would spend more on packing them than on multiplying: there every entry is a
// sum of lanes of its own.

constexpr Eigen::Index few_rows = 16;
constexpr Eigen::Index strip = 1024; ///< Columns, of which the rows stay in the second cache.

using Lanes = double __attribute__((vector_size(32), aligned(8)));

/// add_two_by_four(), or the other way to it.
using AddTwoByFour = void (*)(const double* a, Eigen::Index a_stride, const double* b,
                              Eigen::Index b_stride, Eigen::Index count, double* c,
                              Eigen::Index c_stride);

void add_sums(const Lanes (&sums)[2][4], double* c, Eigen::Index c_stride)
{
    for (Eigen::Index i = 0; i < 2; ++i)
        for (Eigen::Index j = 0; j < 4; ++j) {
            const Lanes& sum = sums[i][j];
            c[i * c_stride + j] += (sum[0] + sum[1]) + (sum[2] + sum[3]);
        }
}

/// c(i, j) += sum_k a(i, k) b(j, k),  i < 2, j < 4, k < count, which is a multiple of 4.
///
///     a:  row 0:  [a00 a01 a02 a03] [a04 ..        b:  row 0:  [b00 b01 b02 b03] [b04 ..
///         row 1:  [a10 ..                              rows 1 to 3, a stride apart
///
///     sums[i][j] = [k = 0, 4, ..  k = 1, 5, ..  k = 2, 6, ..  k = 3, 7, ..], added up at the end.
///
/// The plain loop loads two numbers for a multiplication and waits for each addition to end; here six
/// loads serve eight products of four lanes, whose eight sums do not wait for each other and fit
/// into the 16 registers of AVX2 with what is loaded.
SHAPE_VECTORISED void add_two_by_four(const double* a, Eigen::Index a_stride, const double* b,
                                      Eigen::Index b_stride, Eigen::Index count, double* c,
                                      Eigen::Index c_stride)
{
    Lanes sums[2][4] = {};
    for (Eigen::Index k = 0; k < count; k += 4) {
        const Lanes a0 = *reinterpret_cast<const Lanes*>(a + k);
        const Lanes a1 = *reinterpret_cast<const Lanes*>(a + a_stride + k);
        for (Eigen::Index j = 0; j < 4; ++j) {
            const Lanes bj = *reinterpret_cast<const Lanes*>(b + j * b_stride + k);
            sums[0][j] += a0 * bj;
            sums[1][j] += a1 * bj;
        }
    }
    add_sums(sums, c, c_stride);
}

#ifdef __x86_64__

/// The same where the processor multiplies and adds at once, in half the time; as BLAS does, whose bits
/// depend on the processor too.
__attribute__((target("avx2,fma"))) void add_two_by_four_fused(
    const double* a, Eigen::Index a_stride, const double* b, Eigen::Index b_stride,
    Eigen::Index count, double* c, Eigen::Index c_stride)
{
    Lanes sums[2][4] = {};
    for (Eigen::Index k = 0; k < count; k += 4) {
        const __m256d a0 = _mm256_loadu_pd(a + k);
        const __m256d a1 = _mm256_loadu_pd(a + a_stride + k);
        for (Eigen::Index j = 0; j < 4; ++j) {
            const __m256d bj = _mm256_loadu_pd(b + j * b_stride + k);
            sums[0][j] = _mm256_fmadd_pd(a0, bj, sums[0][j]);
            sums[1][j] = _mm256_fmadd_pd(a1, bj, sums[1][j]);
        }
    }
    add_sums(sums, c, c_stride);
}

#endif

AddTwoByFour best_add_two_by_four()
{
#ifdef __x86_64__
    if (__builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma"))
        return &add_two_by_four_fused;
#endif
    return &add_two_by_four;
}

double inner_product(const double* a, const double* b, Eigen::Index count)
{
    Lanes sum = {};
    for (Eigen::Index k = 0; k < count; ++k)
        sum[k % 4] += a[k] * b[k];
    return (sum[0] + sum[1]) + (sum[2] + sum[3]);
}

void add_inner_products(const ConstBlock& a, const ConstBlock& b, Block c)
{
    static const AddTwoByFour add = best_add_two_by_four();
    const auto row = [](const ConstBlock& block, Eigen::Index i, Eigen::Index first) {
        return block.data() + i * block.outerStride() + first;
    };
    for (Eigen::Index first = 0; first < a.cols(); first += strip) {
        const Eigen::Index count = std::min(strip, a.cols() - first);
        const Eigen::Index whole = count / 4 * 4;
        for (Eigen::Index i = 0; i < a.rows(); i += 2)
            for (Eigen::Index j = 0; j < b.rows(); j += 4) {
                if (i + 2 <= a.rows() && j + 4 <= b.rows()) {
                    add(row(a, i, first), a.outerStride(), row(b, j, first), b.outerStride(), whole,
                        &c(i, j), c.outerStride());
                } else {
                    for (Eigen::Index y = i; y < std::min(i + 2, a.rows()); ++y)
                        for (Eigen::Index x = j; x < std::min(j + 4, b.rows()); ++x)
                            c(y, x) += inner_product(row(a, y, first), row(b, x, first), whole);
                }
            }
        for (Eigen::Index k = first + whole; k < first + count; ++k)
            c += a.col(k) * b.col(k).transpose();
    }
}

} // namespace

void add_product(const ConstBlock& a, const ConstBlock& b, Block c)
{
    multiply(CblasNoTrans, CblasNoTrans, a.cols(), a, b, c);
}

void add_product_with_rows(const ConstBlock& a, const ConstBlock& b, Block c)
{
    if (a.rows() <= few_rows && b.rows() <= few_rows)
        return add_inner_products(a, b, c);
    multiply(CblasNoTrans, CblasTrans, a.cols(), a, b, c);
}

void add_product_of_columns(const ConstBlock& a, const ConstBlock& b, Block c)
{
    multiply(CblasTrans, CblasNoTrans, a.rows(), a, b, c);
}

} // namespace shape::internal
