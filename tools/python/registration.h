// SPDX-License-Identifier: MIT

#pragma once

#include <pybind11/pybind11.h>

namespace shape::python {

void add_registration(pybind11::module_& module);

} // namespace shape::python
