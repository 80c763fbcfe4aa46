// SPDX-License-Identifier: MIT

#pragma once

#include <hdf5.h>

#include <cstddef>
#include <exception>
#include <filesystem>
#include <stdexcept>
#include <utility>
#include <vector>

#include "libshape/io/hdf5/extents.h"

namespace shape::internal {

inline constexpr std::size_t longest_string = 4096; ///< [byte]

/// Keeps HDF5 from printing its errors in this thread while it lives; for good if an exception ends
/// it, for HDF5 1.10 loses objects when a call fails, and would print that at exit.
class Silence
{
public:
    Silence()
    {
        H5Eget_auto2(H5E_DEFAULT, &function_, &data_);
        H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
    }
    ~Silence()
    {
        if (std::uncaught_exceptions() == exceptions_)
            H5Eset_auto2(H5E_DEFAULT, function_, data_);
    }
    Silence(const Silence&) = delete;
    Silence& operator=(const Silence&) = delete;

private:
    int exceptions_ = std::uncaught_exceptions();
    H5E_auto2_t function_ = nullptr;
    void* data_ = nullptr;
};

/// An HDF5 call failed; the callers say which file and what it means there.
class Hdf5Failure : public std::runtime_error
{
public:
    using std::runtime_error::runtime_error;
};

/// Throws Hdf5Failure with what HDF5 says about its last error, as the innermost function put it; or
/// std::bad_alloc if that was an allocation and the system limits the memory (without a limit it is a
/// damaged file that asks for too much).
[[noreturn]] void throw_last_failure();

/// Passes on a result that is not negative: so every call is checked.
template <class Result>
Result checked(Result result)
{
    if (result < 0)
        throw_last_failure();
    return result;
}

/// An identifier and the function that closes it.
class Id
{
public:
    Id(hid_t id, herr_t (*closer)(hid_t)) : id_(checked(id)), close_(closer) {}
    ~Id()
    {
        if (id_ >= 0)
            close_(id_);
    }
    Id(Id&& other) noexcept : id_(std::exchange(other.id_, -1)), close_(other.close_) {}
    Id& operator=(Id&&) = delete;

    operator hid_t() const { return id_; } // NOLINT(google-explicit-constructor): as HDF5 takes it

    /// Closing may write, and fail.
    void close() { checked(close_(std::exchange(id_, -1))); }

private:
    hid_t id_;
    herr_t (*close_)(hid_t);
};

[[nodiscard]] std::vector<hsize_t> dimensions(const Extents& extents);

[[nodiscard]] Id make_space(const Extents& extents);

/// Opens a file for reading.
[[nodiscard]] Id open_file(const std::filesystem::path& path);

} // namespace shape::internal
