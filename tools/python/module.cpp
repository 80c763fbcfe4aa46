// SPDX-License-Identifier: MIT

#include <pybind11/pybind11.h>

#include <cstring>
#include <filesystem>
#include <thread>

#include "libshape/base/error.h"
#include "libshape/base/threads.h"
#include "libshape/base/version.h"
#include "libshape/io/hdf5/untrusted_files.h"
#include "libshape/io/label_file.h"
#include "tools/program/arguments.h"
#include "tools/program/explained.h"
#include "tools/python/handles.h"
#include "tools/python/jobs.h"
#include "tools/python/registration.h"

// libshape._core: what the Python files of the package stand on. Arguments have been checked there.

namespace {

namespace py = pybind11;
using namespace shape;

/// Raises what a function of libshape/_errors.py makes of a message.
void raise(const char* maker, const char* message)
{
    const auto length = static_cast<Py_ssize_t>(std::strlen(message));
    const auto text = py::reinterpret_steal<py::object>(
        PyUnicode_DecodeUTF8(message, length, "surrogateescape")); // paths are bytes
    const py::object error = py::module_::import("libshape._errors").attr(maker)(text);
    PyErr_SetObject(py::type::handle_of(error).ptr(), error.ptr());
}

// NOLINTNEXTLINE(performance-unnecessary-value-param): pybind11's type
void translate(std::exception_ptr thrown)
{
    try {
        if (thrown)
            std::rethrow_exception(thrown);
    } catch (const tools::UsageError& error) {
        raise("invalid_input", error.what());
    } catch (const InvalidInput& error) {
        raise("invalid_input", error.what());
    } catch (const NumericalError& error) {
        raise("numerical_error", error.what());
    } catch (const FileError& error) {
        raise("file_error", error.what());
    } catch (const std::filesystem::filesystem_error& error) {
        raise("file_error", tools::explained(error).c_str());
    } catch (const LimitExceeded& error) {
        raise("limit_exceeded", error.what());
    } catch (const Error& error) {
        raise("other_error", error.what());
    }
}

} // namespace

PYBIND11_MODULE(_core, module)
{
    py::register_exception_translator(translate);
    python::add_models(module);
    python::add_collections(module);
    python::add_registration(module);
    module.def("version", &version);
    module.def("thread_count", &thread_count);
    module.def("set_thread_count", &set_thread_count);
    module.def("label_value", [](const std::string& cell) { return label_value(cell); });
    module.def("isolate_hdf5_files", &isolate_hdf5_files);
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
