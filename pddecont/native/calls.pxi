# What calls.py says, for the compiler: see there.
ctypedef void (*Function)(long, double, double*, double*, double*, double*) noexcept nogil


cdef inline void call(long address, long which, double t, double* x, double* xd, double* p, double* out) noexcept nogil:
    (<Function> <void*> address)(which, t, x, xd, p, out)


cdef inline double* offset(double* numbers, long count) noexcept nogil:
    return numbers + count


