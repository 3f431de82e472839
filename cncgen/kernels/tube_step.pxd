# The Newton step of `tube_step`, which another kernel calls as C.

from cncgen.kernels.tube_point cimport Tube

cpdef bint backward(Tube tube, double delta) noexcept nogil
cpdef void forward(Tube tube) noexcept nogil
