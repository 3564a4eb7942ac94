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


cdef (double, double) turned(double x) noexcept nogil
cdef (double, double) _far(double x) noexcept nogil
cdef double _root(double x) noexcept nogil
cdef double _quotient(double x, double y) noexcept nogil
cdef void _run(unsigned long long[::1] code, Py_ssize_t size, double[::1] v,
               Py_ssize_t width) noexcept nogil
cdef void _run_one(unsigned long long[::1] code, Py_ssize_t size, double[::1] v) noexcept nogil
cdef wide _run_block(unsigned long long[::1] code, Py_ssize_t size,
                     double[::1] v) noexcept nogil
cdef Py_ssize_t _columns(double[:, :] part, Py_ssize_t rows) noexcept
cdef Py_ssize_t _gather(double[::1] v, Py_ssize_t row, double[:, :] part, Py_ssize_t start,
                        Py_ssize_t count) noexcept nogil


cdef class Interpreter:
    cdef Py_ssize_t n_inputs, n_outputs, n_constants, n_rows, size, width
    cdef unsigned long long[::1] code, outputs
    cdef double[::1] v
    cdef list slices
    cdef object new_array

    cdef bint is_sound(self) noexcept
    cdef bint copy(self, numbers, Py_ssize_t row, Py_ssize_t count, bint inwards)
