// SPDX-License-Identifier: MIT

#include "libshape/linalg/block_products.h"

#include <cblas.h>
#ifdef __x86_64__
#include <immintrin.h>
#endif

#include <algorithm>
#include <array>

#include "libshape/base/processor.h"
#include "libshape/base/to_size.h"
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
// sum of lanes of its own, which no other entry changes.

constexpr Eigen::Index strip = 512; ///< Columns, of which seven rows stay in the first cache.

using FourDoubles = double __attribute__((vector_size(32), aligned(8)));

/// add_rows() of some number of rows of a and b, or the other way to it.
using AddRows = void (*)(const double* a, Eigen::Index a_stride, const double* b,
                         Eigen::Index b_stride, Eigen::Index count, double* c,
                         Eigen::Index c_stride);

template <int rows, int columns>
void add_lanes(const FourDoubles (&sums)[rows][columns], double* c, Eigen::Index c_stride)
{
    for (int i = 0; i < rows; ++i)
        for (int j = 0; j < columns; ++j) {
            const FourDoubles& sum = sums[i][j];
            c[i * c_stride + j] += (sum[0] + sum[1]) + (sum[2] + sum[3]);
        }
}

/// c(i, j) += sum_k a(i, k) b(j, k),  i < rows, j < columns, k < count, which is a multiple of 4.
///
///     a:  row 0:  [a00 a01 a02 a03] [a04 ..        b:  row 0:  [b00 b01 b02 b03] [b04 ..
///         rows 1 and 2, a stride apart                 rows 1 to 3, a stride apart
///
///     sums[i][j] = [k = 0, 4, ..  k = 1, 5, ..  k = 2, 6, ..  k = 3, 7, ..], added up at the end.
///
/// The plain loop loads two numbers for a multiplication and waits for each addition to end; of three rows and
/// four, seven loads serve twelve products of four lanes, whose sums do not wait for each other and fit
/// into the 16 registers of AVX2 with what is loaded. Fewer of each, at the rim, take the same sums.
template <int rows, int columns>
void add_rows(const double* a, Eigen::Index a_stride, const double* b, Eigen::Index b_stride,
              Eigen::Index count, double* c, Eigen::Index c_stride)
{
    FourDoubles sums[rows][columns] = {};
    for (Eigen::Index k = 0; k < count; k += 4)
        for (int j = 0; j < columns; ++j)
            for (int i = 0; i < rows; ++i)
                sums[i][j] += *reinterpret_cast<const FourDoubles*>(a + i * a_stride + k) *
                              *reinterpret_cast<const FourDoubles*>(b + j * b_stride + k);
    add_lanes(sums, c, c_stride);
}

#ifdef __x86_64__

/// The same where the processor multiplies and adds at once, in half the time; as BLAS does, whose bits
/// depend on the processor too.
template <int rows, int columns>
__attribute__((target("avx2,fma"))) void add_rows_fused(const double* a, Eigen::Index a_stride,
                                                        const double* b, Eigen::Index b_stride,
                                                        Eigen::Index count, double* c,
                                                        Eigen::Index c_stride)
{
    FourDoubles sums[rows][columns] = {};
    for (Eigen::Index k = 0; k < count; k += 4) {
        __m256d ak[rows];
        for (int i = 0; i < rows; ++i)
            ak[i] = _mm256_loadu_pd(a + i * a_stride + k);
        for (int j = 0; j < columns; ++j) {
            const __m256d bjk = _mm256_loadu_pd(b + j * b_stride + k);
            for (int i = 0; i < rows; ++i)
                sums[i][j] = _mm256_fmadd_pd(ak[i], bjk, sums[i][j]);
        }
    }
    add_lanes(sums, c, c_stride);
}

#endif

constexpr Eigen::Index most_rows = 3;
constexpr Eigen::Index most_columns = 4;

/// Of 1 to 3 rows and 1 to 4 columns.
using Kernels = std::array<std::array<AddRows, most_columns>, most_rows>;

Kernels best_kernels()
{
#ifdef __x86_64__
    if (has_fused_avx2())
        return {{{add_rows_fused<1, 1>, add_rows_fused<1, 2>, add_rows_fused<1, 3>,
                  add_rows_fused<1, 4>},
                 {add_rows_fused<2, 1>, add_rows_fused<2, 2>, add_rows_fused<2, 3>,
                  add_rows_fused<2, 4>},
                 {add_rows_fused<3, 1>, add_rows_fused<3, 2>, add_rows_fused<3, 3>,
                  add_rows_fused<3, 4>}}};
#endif
    return {{{add_rows<1, 1>, add_rows<1, 2>, add_rows<1, 3>, add_rows<1, 4>},
             {add_rows<2, 1>, add_rows<2, 2>, add_rows<2, 3>, add_rows<2, 4>},
             {add_rows<3, 1>, add_rows<3, 2>, add_rows<3, 3>, add_rows<3, 4>}}};
}

void add_inner_products(const ConstBlock& a, const ConstBlock& b, Block c)
{
    static const Kernels kernels = best_kernels();
    for (Eigen::Index first = 0; first < a.cols(); first += strip) {
        const Eigen::Index count = std::min(strip, a.cols() - first);
        const Eigen::Index whole = count / 4 * 4;
        for (Eigen::Index j = 0; j < b.rows(); j += most_columns)
            for (Eigen::Index i = 0; i < a.rows(); i += most_rows) {
                const Eigen::Index rows = std::min(most_rows, a.rows() - i);
                const Eigen::Index columns = std::min(most_columns, b.rows() - j);
                kernels[to_size(rows - 1)][to_size(columns - 1)](
                    a.data() + i * a.outerStride() + first, a.outerStride(),
                    b.data() + j * b.outerStride() + first, b.outerStride(), whole, &c(i, j),
                    c.outerStride());
            }
        for (Eigen::Index k = first + whole; k < first + count; ++k)
            c += a.col(k) * b.col(k).transpose();
    }
}

/// add_scaled_rows() of some number of rows of c and vectors of four columns.
using AddScaledRows = void (*)(const double* a, Eigen::Index a_stride, const double* b,
                               Eigen::Index b_stride, Eigen::Index depth, double* c,
                               Eigen::Index c_stride);

/// c(i, k) += a(0, i) b(0, k) + a(1, i) b(1, k) + ..,  i < rows, k < 4 vectors, `depth` terms in their order.
///
///     c:  row 0:  [c00 c01 c02 c03] [c04 ..        b:  row 0:  [b00 b01 b02 b03] [b04 ..
///         rows 1 to 3, a stride apart                  the next `depth` - 1 rows, a stride apart
///     a:  row 0:  a00 a01 a02 a03, each of them in all lanes for row 0, 1, 2, 3 of c
///
/// As the terms of an entry are added to it one after another, bits do not depend on how rows and columns are
/// cut into pieces.
template <int rows, int vectors>
void add_scaled_rows(const double* a, Eigen::Index a_stride, const double* b, Eigen::Index b_stride,
                     Eigen::Index depth, double* c, Eigen::Index c_stride)
{
    for (int i = 0; i < rows; ++i)
        for (int v = 0; v < vectors; ++v) {
            auto& result = *reinterpret_cast<FourDoubles*>(c + i * c_stride + 4 * v);
            for (Eigen::Index r = 0; r < depth; ++r)
                result += a[r * a_stride + i] *
                          *reinterpret_cast<const FourDoubles*>(b + r * b_stride + 4 * v);
        }
}

#ifdef __x86_64__

/// The same where the processor multiplies and adds at once.
template <int rows, int vectors>
__attribute__((target("avx2,fma"))) void add_scaled_rows_fused(
    const double* a, Eigen::Index a_stride, const double* b, Eigen::Index b_stride,
    Eigen::Index depth, double* c, Eigen::Index c_stride)
{
    __m256d sums[rows][vectors];
#pragma GCC unroll 4
    for (int i = 0; i < rows; ++i)
#pragma GCC unroll 3
        for (int v = 0; v < vectors; ++v)
            sums[i][v] = _mm256_loadu_pd(c + i * c_stride + 4 * v);
    for (Eigen::Index r = 0; r < depth; ++r) {
        __m256d br[vectors];
#pragma GCC unroll 3
        for (int v = 0; v < vectors; ++v)
            br[v] = _mm256_loadu_pd(b + r * b_stride + 4 * v);
#pragma GCC unroll 4
        for (int i = 0; i < rows; ++i) {
            const __m256d ari = _mm256_broadcast_sd(a + r * a_stride + i);
#pragma GCC unroll 3
            for (int v = 0; v < vectors; ++v)
                sums[i][v] = _mm256_fmadd_pd(ari, br[v], sums[i][v]);
        }
    }
#pragma GCC unroll 4
    for (int i = 0; i < rows; ++i)
#pragma GCC unroll 3
        for (int v = 0; v < vectors; ++v)
            _mm256_storeu_pd(c + i * c_stride + 4 * v, sums[i][v]);
}

#endif

constexpr Eigen::Index most_scaled_rows = 4;
constexpr Eigen::Index most_vectors = 3;

/// Of 1 to 4 rows and 1 to 3 vectors.
using ScaledKernels = std::array<std::array<AddScaledRows, most_vectors>, most_scaled_rows>;

ScaledKernels best_scaled_kernels()
{
#ifdef __x86_64__
    if (has_fused_avx2())
        return {{{add_scaled_rows_fused<1, 1>, add_scaled_rows_fused<1, 2>,
                  add_scaled_rows_fused<1, 3>},
                 {add_scaled_rows_fused<2, 1>, add_scaled_rows_fused<2, 2>,
                  add_scaled_rows_fused<2, 3>},
                 {add_scaled_rows_fused<3, 1>, add_scaled_rows_fused<3, 2>,
                  add_scaled_rows_fused<3, 3>},
                 {add_scaled_rows_fused<4, 1>, add_scaled_rows_fused<4, 2>,
                  add_scaled_rows_fused<4, 3>}}};
#endif
    return {{{add_scaled_rows<1, 1>, add_scaled_rows<1, 2>, add_scaled_rows<1, 3>},
             {add_scaled_rows<2, 1>, add_scaled_rows<2, 2>, add_scaled_rows<2, 3>},
             {add_scaled_rows<3, 1>, add_scaled_rows<3, 2>, add_scaled_rows<3, 3>},
             {add_scaled_rows<4, 1>, add_scaled_rows<4, 2>, add_scaled_rows<4, 3>}}};
}

/// Columns `first` to the last, fewer than four, by way of whole vectors.
void add_last_columns(AddScaledRows kernel, Eigen::Index first, const ConstBlock& a,
                      const ConstBlock& b, Block c)
{
    using Vectors = Eigen::Matrix<double, Eigen::Dynamic, 4, Eigen::RowMajor>;
    const Eigen::Index count = b.cols() - first;
    Vectors right = Vectors::Zero(b.rows(), 4);
    Vectors sum = Vectors::Zero(c.rows(), 4);
    right.leftCols(count) = b.rightCols(count);
    sum.leftCols(count) = c.rightCols(count);
    kernel(a.data(), a.outerStride(), right.data(), 4, a.rows(), sum.data(), 4);
    c.rightCols(count) = sum.leftCols(count);
}

void add_scaled_rows_of(const ConstBlock& a, const ConstBlock& b, Block c)
{
    static const ScaledKernels kernels = best_scaled_kernels();
    constexpr Eigen::Index width = 192;
    for (Eigen::Index first = 0; first < b.cols(); first += width)
        for (Eigen::Index i = 0; i < c.rows(); i += most_scaled_rows) {
            const Eigen::Index rows = std::min(most_scaled_rows, c.rows() - i);
            const auto& of_rows = kernels[to_size(rows - 1)];
            const Eigen::Index end = std::min(first + width, b.cols());
            Eigen::Index k = first;
            while (k + 4 <= end) {
                const Eigen::Index vectors = std::min(most_vectors, (end - k) / 4);
                of_rows[to_size(vectors - 1)](a.data() + i, a.outerStride(), b.data() + k,
                                              b.outerStride(), a.rows(),
                                              c.data() + i * c.outerStride() + k, c.outerStride());
                k += 4 * vectors;
            }
            if (k < end)
                add_last_columns(of_rows[0], k, a.middleCols(i, rows), b, c.middleRows(i, rows));
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
    constexpr Eigen::Index batch = 16; // rows of 192 columns, which the first cache holds
    for (Eigen::Index first = 0; first < a.rows(); first += batch) {
        const Eigen::Index count = std::min(batch, a.rows() - first);
        add_scaled_rows_of(a.middleRows(first, count), b.middleRows(first, count), c);
    }
}

} // namespace shape::internal
