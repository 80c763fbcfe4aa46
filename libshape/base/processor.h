// SPDX-License-Identifier: MIT

#pragma once

namespace shape::internal {

/// Whether kernels written for AVX2 may be called, and whether those that multiply and add at once may.
#ifdef __x86_64__
inline bool has_avx2()
{
    return __builtin_cpu_supports("avx2");
}
inline bool has_fused_avx2()
{
    return __builtin_cpu_supports("avx2") && __builtin_cpu_supports("fma");
}
#endif

} // namespace shape::internal
