// SPDX-License-Identifier: MIT

#include "libshape/base/gathered_vectors.h"

#include <gtest/gtest.h>

#include <memory>
#include <random>
#include <vector>

#include "libshape/base/to_size.h"

namespace shape {
using namespace internal;
namespace {

constexpr int points = 50;

/// On the heap, without room behind the last point: the sanitizers see what is read beyond it.
struct Cloud
{
    Cloud()
    {
        std::mt19937_64 random(7);
        for (int i = 0; i < 3 * points; ++i)
            numbers[to_size(i)] = 1e-3 * static_cast<double>(random() % 100000) - 31.0;
    }
    [[nodiscard]] Vector3<double> operator[](int i) const { return vector3(numbers.get() + 3 * i); }
    std::unique_ptr<double[]> numbers = std::make_unique<double[]>(3 * points);
};

std::vector<int> some_indices(int count, unsigned seed)
{
    std::mt19937_64 random(seed);
    std::vector<int> indices;
    for (int i = 0; i < count; ++i)
        indices.push_back(static_cast<int>(random() % points));
    indices.back() = points - 1;
    return indices;
}

void expect_equal(const Vector3<double>& found, const Vector3<double>& wanted)
{
    EXPECT_EQ(found.x, wanted.x);
    EXPECT_EQ(found.y, wanted.y);
    EXPECT_EQ(found.z, wanted.z);
}

TEST(GatheredVectors, AreThoseOfTheIndicesForEveryCountAndStride)
{
    const Cloud cloud;
    for (const int stride : {1, 2, 4})
        for (const int count : {1, 3, 4, 5, 127, block_size}) {
            const std::vector<int> indices = some_indices(stride * (count - 1) + 1, 3);
            VectorRows found;
            gather(count, cloud.numbers.get(), {indices.data(), stride}, found);
            for (int i = 0; i < count; ++i)
                expect_equal(found[i], cloud[indices[to_size(stride * i)]]);
        }
}

TEST(GatheredVectors, AreDifferencesRoundedOnce)
{
    const Cloud cloud;
    for (const int count : {1, 2, 4, 7, block_size}) {
        const std::vector<int> to = some_indices(2 * count - 1, 4);
        const std::vector<int> from = some_indices(count, 5);
        VectorRows found;
        gather_differences(count, cloud.numbers.get(), {to.data(), 2}, {from.data()}, found);
        for (int i = 0; i < count; ++i)
            expect_equal(found[i], cloud[to[to_size(2 * i)]] - cloud[from[to_size(i)]]);
    }
}

TEST(GatheredVectors, LeavesWhatLiesBehindTheLastOne)
{
    const Cloud cloud;
    const std::vector<int> indices = some_indices(6, 6);
    VectorRows found;
    found.set(6, {1.0, 2.0, 3.0});
    gather(6, cloud.numbers.get(), {indices.data()}, found);
    gather_differences(6, cloud.numbers.get(), {indices.data()}, {indices.data()}, found);
    expect_equal(found[6], {1.0, 2.0, 3.0});
}

} // namespace
} // namespace shape
