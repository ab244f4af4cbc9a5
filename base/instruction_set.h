// SPDX-License-Identifier: Apache-2.0
#pragma once

/// SOAK_CLONES before a function compiles it twice, for any x86-64 processor and for those with AVX2; the loader picks
/// one when the program starts. Both give the same bits as long as the function fixes the order of its additions
/// (contraction is off in the whole build). Functions that it calls must be SOAK_INLINE to be compiled along with it.
/// ThreadSanitizer crashes on such functions before main: there it means nothing.
#if defined(__x86_64__) && !defined(__SANITIZE_THREAD__)
#define SOAK_CLONES __attribute__((target_clones("default", "arch=x86-64-v3")))
#else
#define SOAK_CLONES
#endif

#define SOAK_INLINE inline __attribute__((always_inline))
