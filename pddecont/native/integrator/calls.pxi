# What calls.py says, for the compiler: see there.
from scipy.linalg.cython_lapack cimport dgetrf, dgetrs


# LAPACK's matrices lie column by column: it has the transpose, and solves with the transpose of that.
cdef bint factorise(double* matrix, long* pivots, long n) noexcept nogil:
    cdef int size = <int> n, info = 0
    dgetrf(&size, &size, matrix, &size, <int*> pivots, &info)
    return info == 0


cdef void solve_factorised(double* matrix, long* pivots, long n, double* right) noexcept nogil:
    cdef int size = <int> n, one = 1, info = 0
    dgetrs("T", &size, &one, matrix, &size, <int*> pivots, right, &size, &info)
