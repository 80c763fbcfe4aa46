// SPDX-License-Identifier: MIT

#include "libshape/base/gathered_vectors.h"

#include "libshape/base/processor.h"

#ifdef __x86_64__
#include <immintrin.h>
#endif

namespace shape::internal {
namespace {

const double* point(const double* points, StridedRows rows, int i)
{
    return points + 3 * rows.first[i * rows.stride];
}

void gather_plainly(int begin, int count, const double* points, StridedRows at, VectorRows& vectors)
{
    for (int i = begin; i < count; ++i)
        vectors.set(i, vector3(point(points, at, i)));
}

void subtract_plainly(int begin, int count, const double* points, StridedRows to, StridedRows from,
                      VectorRows& vectors)
{
    for (int i = begin; i < count; ++i)
        vectors.set(i, vector3(point(points, to, i)) - vector3(point(points, from, i)));
}

#ifdef __x86_64__

/// [x y | y z]: two loads, none of them beyond the point.
__attribute__((target("avx2"))) inline __m256d load(const double* point)
{
    return _mm256_insertf128_pd(_mm256_castpd128_pd256(_mm_loadu_pd(point)),
                                _mm_loadu_pd(point + 1), 1);
}

/// Four vectors into their rows, from i on:
///
///     a: [ax ay | ay az]        low:  [ax bx | ay by]  [cx dx | cy dy]       x: [ax bx cx dx]
///     b: [bx by | by bz]   ->   high: [ay by | az bz]  [cy dy | cz dz]  ->   y: [ay by cy dy]
///     c, d likewise                                                          z: [az bz cz dz]
__attribute__((target("avx2"))) inline void set_four(__m256d a, __m256d b, __m256d c, __m256d d,
                                                     int i, VectorRows& vectors)
{
    const __m256d low = _mm256_unpacklo_pd(a, b);
    const __m256d high = _mm256_unpackhi_pd(a, b);
    const __m256d next_low = _mm256_unpacklo_pd(c, d);
    const __m256d next_high = _mm256_unpackhi_pd(c, d);
    _mm256_storeu_pd(vectors.x + i, _mm256_permute2f128_pd(low, next_low, 0x20));
    _mm256_storeu_pd(vectors.y + i, _mm256_permute2f128_pd(high, next_high, 0x20));
    _mm256_storeu_pd(vectors.z + i, _mm256_permute2f128_pd(high, next_high, 0x31));
}

// The plain loop moves every number by itself, three loads, subtractions and stores a vector; here four
// vectors are loaded whole and turned into rows by seven shuffles.

__attribute__((target("avx2"))) void gather_by_fours(int count, const double* points,
                                                     StridedRows at, VectorRows& vectors)
{
    int i = 0;
    for (; i + 4 <= count; i += 4)
        set_four(load(point(points, at, i)), load(point(points, at, i + 1)),
                 load(point(points, at, i + 2)), load(point(points, at, i + 3)), i, vectors);
    gather_plainly(i, count, points, at, vectors);
}

__attribute__((target("avx2"))) void subtract_by_fours(int count, const double* points,
                                                       StridedRows to, StridedRows from,
                                                       VectorRows& vectors)
{
    int i = 0;
    for (; i + 4 <= count; i += 4) {
        __m256d four[4];
        for (int k = 0; k < 4; ++k)
            four[k] =
                _mm256_sub_pd(load(point(points, to, i + k)), load(point(points, from, i + k)));
        set_four(four[0], four[1], four[2], four[3], i, vectors);
    }
    subtract_plainly(i, count, points, to, from, vectors);
}

#endif

} // namespace

void gather(int count, const double* points, StridedRows at, VectorRows& vectors)
{
#ifdef __x86_64__
    if (has_avx2())
        return gather_by_fours(count, points, at, vectors);
#endif
    gather_plainly(0, count, points, at, vectors);
}

void gather_differences(int count, const double* points, StridedRows to, StridedRows from,
                        VectorRows& vectors)
{
#ifdef __x86_64__
    if (has_avx2())
        return subtract_by_fours(count, points, to, from, vectors);
#endif
    subtract_plainly(0, count, points, to, from, vectors);
}

} // namespace shape::internal
