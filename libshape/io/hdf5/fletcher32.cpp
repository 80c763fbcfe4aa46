// SPDX-License-Identifier: MIT

#include "libshape/io/hdf5/fletcher32.h"

#include <algorithm>
#include <cstring>

#include "libshape/base/vectorised.h"

namespace shape::internal {
namespace {

// With words w_1 .. w_n the sums are  s = sum_i w_i  and  t = sum_i (n + 1 - i) w_i. A part of m words
// changes them by
//
//     t += m s + sum_i (m + 1 - i) w_i,     s += sum_i w_i,
//
// and both sums of a part are plain ones, which vectorise. HDF5 reads words with the high byte first;
// swapping the bytes of a word is to multiply it by 256 modulo 65535, so it is done once, to the sums.

constexpr std::uint32_t part = 256; // its sums stay below 2^32

struct Sums
{
    std::uint32_t plain;
    std::uint32_t weighted;
};

SHAPE_VECTORISED Sums sum_part(const unsigned char* bytes)
{
    std::uint16_t words[part];
    std::memcpy(words, bytes, sizeof words);
    std::uint32_t plain = 0;
    std::uint32_t weighted = 0;
    for (std::uint32_t i = 0; i < part; ++i) {
        const std::uint32_t word = words[i];
        plain += word;
        weighted += (part - i) * word;
    }
    return {plain, weighted};
}

/// HDF5 reduces by adding the upper half to the lower one: 0 remains only if all words are 0.
std::uint32_t reduced(std::uint64_t sum, bool all_zero)
{
    const auto rest = static_cast<std::uint32_t>(sum % 65535);
    return rest == 0 && !all_zero ? 65535 : rest;
}

} // namespace

std::uint32_t fletcher32(const unsigned char* bytes, std::size_t count)
{
    std::uint64_t s = 0;
    std::uint64_t t = 0;
    std::uint64_t any = 0;
    std::size_t words = count / 2;
    for (; words >= part; words -= part, bytes += 2 * part) {
        const Sums sums = sum_part(bytes);
        t = (t + part * s + sums.weighted) % 65535;
        s = (s + sums.plain) % 65535;
        any |= sums.plain;
    }
    for (; words > 0; --words, bytes += 2) {
        std::uint16_t word = 0;
        std::memcpy(&word, bytes, sizeof word);
        s += word;
        t = (t + s) % 65535;
        any |= word;
    }
    if (count % 2 != 0) { // its last byte is the high one of a word
        s += *bytes;
        t = (t + s) % 65535;
        any |= *bytes;
    }
    return reduced(256 * (t % 65535), any == 0) << 16 | reduced(256 * (s % 65535), any == 0);
}

} // namespace shape::internal
