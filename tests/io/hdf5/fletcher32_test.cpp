// SPDX-License-Identifier: MIT

#include "libshape/io/hdf5/fletcher32.h"

#include <gtest/gtest.h>

#include <vector>

#include "libshape/base/random.h"

namespace shape {
using namespace internal;
namespace {

/// The definition, word by word as HDF5 has it: high byte first, sums folded at the end of each word.
std::uint32_t by_definition(const std::vector<unsigned char>& bytes)
{
    std::uint32_t low = 0;
    std::uint32_t high = 0;
    const auto add = [&](std::uint32_t word) {
        low += word;
        high += low;
        low = (low & 0xffff) + (low >> 16);
        high = (high & 0xffff) + (high >> 16);
    };
    for (std::size_t i = 0; i + 1 < bytes.size(); i += 2)
        add(static_cast<std::uint32_t>(bytes[i]) << 8 | bytes[i + 1]);
    if (bytes.size() % 2 != 0)
        add(static_cast<std::uint32_t>(bytes.back()) << 8);
    low = (low & 0xffff) + (low >> 16);
    high = (high & 0xffff) + (high >> 16);
    return high << 16 | low;
}

TEST(Fletcher32, IsThatOfItsDefinitionAtEverySize)
{
    Random random(1);
    for (const std::size_t size :
         {0U, 1U, 2U, 3U, 511U, 512U, 513U, 514U, 1024U, 4097U, 65536U, 300001U}) {
        std::vector<unsigned char> bytes(size);
        for (unsigned char& byte : bytes)
            byte = static_cast<unsigned char>(random.index(256));
        EXPECT_EQ(fletcher32(bytes.data(), size), by_definition(bytes)) << size;
        for (const unsigned char same : {std::uint8_t{0}, std::uint8_t{255}}) {
            bytes.assign(size, same);
            EXPECT_EQ(fletcher32(bytes.data(), size), by_definition(bytes)) << size;
        }
    }
}

TEST(Fletcher32, NoticesEveryFlippedBit)
{
    std::vector<unsigned char> bytes(2048, 7);
    const std::uint32_t sound = fletcher32(bytes.data(), bytes.size());
    for (std::size_t bit = 0; bit < 8 * bytes.size(); ++bit) {
        bytes[bit / 8] ^= static_cast<unsigned char>(1U << bit % 8);
        EXPECT_NE(fletcher32(bytes.data(), bytes.size()), sound) << bit;
        bytes[bit / 8] ^= static_cast<unsigned char>(1U << bit % 8);
    }
}

} // namespace
} // namespace shape
