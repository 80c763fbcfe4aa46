// SPDX-License-Identifier: MIT

#pragma once

#include <bit>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <span>
#include <string>
#include <type_traits>
#include <vector>

#include "libshape/base/error.h"
#include "libshape/base/format.h"
#include "libshape/base/to_size.h"

namespace shape::internal {

static_assert(std::endian::native == std::endian::little, "numbers are written as they lie");

/// Numbers and arrays of them one after the other, little-endian. An array is its count as 64 bits,
/// then its items; every array starts at a multiple of eight bytes.
class ByteWriter
{
public:
    template <class Number>
    void number(Number value)
    {
        static_assert(std::is_arithmetic_v<Number>);
        append(&value, sizeof value);
    }

    template <class Item>
    void array(const Item* items, std::size_t count)
    {
        static_assert(std::is_trivially_copyable_v<Item> && alignof(Item) <= 8);
        bytes_.resize((bytes_.size() + 7) / 8 * 8);
        number(static_cast<std::uint64_t>(count));
        append(items, count * sizeof(Item));
    }
    template <class Items>
    void array(const Items& items)
    {
        array(items.data(), to_size(items.size()));
    }

    [[nodiscard]] const std::vector<unsigned char>& bytes() const { return bytes_; }

private:
    void append(const void* from, std::size_t size)
    {
        const std::size_t place = bytes_.size();
        bytes_.resize(place + size);
        if (size > 0)
            std::memcpy(bytes_.data() + place, from, size);
    }

    std::vector<unsigned char> bytes_;
};

/// Reads what a ByteWriter wrote. The bytes must outlive it.
class ByteReader
{
public:
    explicit ByteReader(std::span<const unsigned char> bytes) : bytes_(bytes) {}

    /// @throws InvalidInput if the bytes end before, as all below.
    template <class Number>
    [[nodiscard]] Number number()
    {
        static_assert(std::is_arithmetic_v<Number>);
        Number value{};
        std::memcpy(&value, take(sizeof value), sizeof value);
        return value;
    }

    /// A copy.
    template <class Item>
    [[nodiscard]] std::vector<Item> array()
    {
        const std::size_t count = count_of(sizeof(Item));
        std::vector<Item> items(count);
        if (count > 0)
            std::memcpy(items.data(), take(count * sizeof(Item)), count * sizeof(Item));
        return items;
    }

    /// Into a matrix of the right size.
    /// @throws InvalidInput as well if the array has another size.
    template <class Matrix>
    void array_into(Matrix& matrix)
    {
        using Item = typename Matrix::Scalar;
        const std::size_t count = count_of(sizeof(Item));
        if (count != to_size(matrix.size()))
            throw InvalidInput(
                join("bytes: an array has ", count, " items, must have ", matrix.size()));
        if (count > 0)
            std::memcpy(matrix.data(), take(count * sizeof(Item)), count * sizeof(Item));
    }

private:
    std::size_t count_of(std::size_t item_size)
    {
        (void)take((place_ + 7) / 8 * 8 - place_);
        const auto count = number<std::uint64_t>();
        if (count > (bytes_.size() - place_) / item_size)
            throw InvalidInput(join("bytes: an array of ", count, " items of ", item_size,
                                    " bytes, ", bytes_.size() - place_, " bytes are left"));
        return to_size(count);
    }
    const unsigned char* take(std::size_t size)
    {
        if (size > bytes_.size() - place_)
            throw InvalidInput(
                join("bytes: ", size, " wanted, ", bytes_.size() - place_, " are left"));
        const unsigned char* const at = bytes_.data() + place_;
        place_ += size;
        return at;
    }

    std::span<const unsigned char> bytes_;
    std::size_t place_ = 0;
};

} // namespace shape::internal
