// SPDX-License-Identifier: MIT

#include "libshape/base/gathered_vectors.h"

#include <cstring>

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

using Two = double __attribute__((vector_size(16)));

/// A point as x y and z.
struct Loaded
{
    Two xy;
    double z;
};
[[gnu::always_inline]] inline Loaded loaded(const double* point)
{
    Loaded result;
    std::memcpy(&result.xy, point, sizeof result.xy);
    result.z = point[2];
    return result;
}

/// Two vectors into their rows, from i on:   [ax ay] az, [bx by] bz   ->   [ax bx], [ay by], [az bz].
[[gnu::always_inline]] inline void set_two(const Loaded& a, const Loaded& b, int i,
                                           VectorRows& vectors)
{
    const Two x = __builtin_shufflevector(a.xy, b.xy, 0, 2);
    const Two y = __builtin_shufflevector(a.xy, b.xy, 1, 3);
    const Two z{a.z, b.z};
    std::memcpy(vectors.x + i, &x, sizeof x);
    std::memcpy(vectors.y + i, &y, sizeof y);
    std::memcpy(vectors.z + i, &z, sizeof z);
}

[[gnu::always_inline]] inline Loaded difference(const double* to, const double* from)
{
    const Loaded a = loaded(to);
    const Loaded b = loaded(from);
    return {a.xy - b.xy, a.z - b.z};
}

// For any processor with registers of two doubles, WebAssembly's among them.

void gather_by_twos(int begin, int count, const double* points, StridedRows at, VectorRows& vectors)
{
    int i = begin;
    for (; i + 2 <= count; i += 2)
        set_two(loaded(point(points, at, i)), loaded(point(points, at, i + 1)), i, vectors);
    for (; i < count; ++i)
        vectors.set(i, vector3(point(points, at, i)));
}

void subtract_by_twos(int begin, int count, const double* points, StridedRows to, StridedRows from,
                      VectorRows& vectors)
{
    int i = begin;
    for (; i + 2 <= count; i += 2)
        set_two(difference(point(points, to, i), point(points, from, i)),
                difference(point(points, to, i + 1), point(points, from, i + 1)), i, vectors);
    for (; i < count; ++i)
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
    gather_by_twos(i, count, points, at, vectors);
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
    subtract_by_twos(i, count, points, to, from, vectors);
}

#endif

} // namespace

void gather(int count, const double* points, StridedRows at, VectorRows& vectors)
{
#ifdef __x86_64__
    if (has_avx2())
        return gather_by_fours(count, points, at, vectors);
#endif
    gather_by_twos(0, count, points, at, vectors);
}

void gather_differences(int count, const double* points, StridedRows to, StridedRows from,
                        VectorRows& vectors)
{
#ifdef __x86_64__
    if (has_avx2())
        return subtract_by_fours(count, points, to, from, vectors);
#endif
    subtract_by_twos(0, count, points, to, from, vectors);
}

} // namespace shape::internal
