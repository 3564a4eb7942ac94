# Copyright screw_kinematics contributors
# SPDX-License-Identifier: Apache-2.0

cdef extern from *:
    """
    /* The return type of functions that are compiled twice, for processors with and without AVX2;
       which of them runs is decided when the module is loaded. Both give the same bits. */
    #if defined(__x86_64__) && defined(__gnu_linux__) && !defined(__SANITIZE_ADDRESS__) \
        && (defined(__clang__) ? __clang_major__ >= 14 : defined(__GNUC__))
    #pragma GCC diagnostic ignored "-Wattributes"
    #define WIDE_WHERE_POSSIBLE __attribute__((flatten, target_clones("avx2", "default"))) int
    #else
    #define WIDE_WHERE_POSSIBLE int
    #endif
    """
    ctypedef int wide "WIDE_WHERE_POSSIBLE"
