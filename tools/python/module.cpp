// SPDX-License-Identifier: MIT

#include <pybind11/pybind11.h>

#include <thread>

#include "libshape/base/error.h"
#include "libshape/base/threads.h"
#include "libshape/base/version.h"
#include "tools/program/arguments.h"
#include "tools/python/handles.h"
#include "tools/python/jobs.h"
#include "tools/python/registration.h"

// libshape._core: what the Python files of the package stand on. Arguments have been checked there.

PYBIND11_MODULE(_core, module)
{
    namespace py = pybind11;
    using namespace shape;
    static const py::exception<Error> error(module, "Error");
    const auto add = [&]<class Kind>(Kind*, const char* name, PyObject* base) {
        py::register_exception<Kind>(module, name, py::make_tuple(error, py::handle(base)));
    };
    // Those registered last are tried first.
    py::register_exception<Error>(module, "OtherError", error);
    add(static_cast<InvalidInput*>(nullptr), "InvalidInput", PyExc_ValueError);
    add(static_cast<NumericalError*>(nullptr), "NumericalError", PyExc_ArithmeticError);
    add(static_cast<FileError*>(nullptr), "FileError", PyExc_OSError);
    add(static_cast<LimitExceeded*>(nullptr), "LimitExceeded", PyExc_ValueError);
    py::register_exception_translator([](std::exception_ptr thrown) {
        try {
            if (thrown)
                std::rethrow_exception(thrown);
        } catch (const tools::UsageError& usage) {
            PyErr_SetString(PyExc_ValueError, usage.what());
        }
    });
    python::add_models(module);
    python::add_collections(module);
    python::add_registration(module);
    module.def("version", &version);
    module.def("thread_count", &thread_count);
    module.def("set_thread_count", &set_thread_count);
    // For the tests: work that takes this long and looks up every so often, or nothing at all.
    module.def("wait", [](double seconds, double step, const py::object& callback) {
        return python::run(
            [=](const Progress& progress) {
                const auto steps = static_cast<std::size_t>(seconds / step);
                for (std::size_t i = 0; i < steps; ++i) {
                    progress("waiting", i, steps);
                    std::this_thread::sleep_for(std::chrono::duration<double>(step));
                }
                progress("waiting", steps, steps);
                return true;
            },
            callback);
    });
    py::module_::import("atexit").attr("register")(py::cpp_function(&python::end_jobs));
}
