// SPDX-License-Identifier: MIT

#pragma once

#include <pybind11/numpy.h>
#include <pybind11/stl.h>

#include <Eigen/Core>
#include <memory>
#include <string>
#include <vector>

#include "libshape/linalg/dense.h"
#include "libshape/mesh/points.h"

// Arrays of NumPy from those of Eigen, without copies, and the reverse. The Python files have checked kinds and
// shapes.

namespace shape::python {

namespace py = pybind11;

using Doubles = py::array_t<double, py::array::c_style>;
using Integers = py::array_t<std::int64_t, py::array::c_style>;

/// A view of numbers that `owner` keeps.
template <class Owner>
[[nodiscard]] Doubles view(const std::shared_ptr<Owner>& owner, const double* data,
                           std::vector<py::ssize_t> shape)
{
    auto* const kept = new std::shared_ptr<Owner>(owner);
    const py::capsule base(
        kept, [](void* pointer) { delete static_cast<std::shared_ptr<Owner>*>(pointer); });
    Doubles array(std::move(shape), data, base);
    array.attr("flags").attr("writeable") = false;
    return array;
}

/// An array that owns the numbers of a matrix or vector.
template <class Matrix>
[[nodiscard]] Doubles array_of(Matrix matrix)
{
    auto* const kept = new Matrix(std::move(matrix));
    const py::capsule base(kept, [](void* pointer) { delete static_cast<Matrix*>(pointer); });
    if constexpr (Matrix::ColsAtCompileTime == 1)
        return Doubles({kept->size()}, kept->data(), base);
    else {
        static_assert(Matrix::IsRowMajor);
        return Doubles({kept->rows(), kept->cols()}, kept->data(), base);
    }
}

[[nodiscard]] inline Points points_of(const Doubles& array)
{
    return Eigen::Map<const Points>(array.data(), array.shape(0), 3);
}

[[nodiscard]] inline Eigen::VectorXd vector_of(const Doubles& array)
{
    return Eigen::Map<const Eigen::VectorXd>(array.data(), array.size());
}

[[nodiscard]] Faces faces_of(const Integers& array);
[[nodiscard]] Integers array_of_faces(const Faces& faces);

} // namespace shape::python
