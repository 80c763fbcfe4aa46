// SPDX-License-Identifier: MIT

#include "libshape/linalg/blas_turn.h"

#include <cblas.h>
#include <sys/mman.h>

#include <array>
#include <cstddef>
#include <new>

#include "libshape/base/memory_limit.h"

namespace shape::internal {
namespace {

/// Whether the system would give this much now.
bool has_room(std::size_t size)
{
    void* const room =
        mmap(nullptr, size, PROT_READ | PROT_WRITE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
    if (room == MAP_FAILED)
        return false;
    munmap(room, size);
    return true;
}

/// Multiplies matrices too large for the stack: OpenBLAS makes its buffer, and keeps it.
void make_buffer()
{
    constexpr int size = 64;
    std::array<double, size * size> a{};
    std::array<double, size * size> c{};
    cblas_dgemm(CblasColMajor, CblasNoTrans, CblasNoTrans, size, size, size, 1.0, a.data(), size,
                a.data(), size, 0.0, c.data(), size);
}

} // namespace

BlasTurn::BlasTurn()
{
    if (!is_memory_limited())
        return;
    static std::mutex mutex;
    static bool has_buffer = false;
    lock_ = std::unique_lock(mutex);
    if (has_buffer)
        return;
    constexpr std::size_t buffer = std::size_t{130} << 20; // 128 MiB in Debian's OpenBLAS, aligned
    if (!has_room(buffer))
        throw std::bad_alloc();
    make_buffer();
    has_buffer = true;
}

} // namespace shape::internal
