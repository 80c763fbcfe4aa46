// SPDX-License-Identifier: MIT

#pragma once

/// Marks a function with plain loops over arrays that is compiled twice, for any processor and for
/// those with AVX2; the program chooses when it starts. Both give the same bits: nothing is
/// contracted or summed in another order. Under AddressSanitizer and ThreadSanitizer once: the
/// choice is made before their run-time libraries are ready.
#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__) && \
    !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
#define SHAPE_VECTORISED __attribute__((target_clones("avx2", "default")))
#else
#define SHAPE_VECTORISED
#endif
