// SPDX-License-Identifier: MIT

#include "libshape/io/hdf5/handles.h"

#include <string>

namespace shape::internal {
namespace {

/// What HDF5 says about its last error, as the innermost function put it.
std::string last_error()
{
    std::string text;
    const auto take = [](unsigned n, const H5E_error2_t* error, void* out) -> herr_t {
        if (n == 0 && error->desc != nullptr)
            *static_cast<std::string*>(out) = error->desc;
        return 0;
    };
    H5Ewalk2(H5E_DEFAULT, H5E_WALK_UPWARD, take, &text);
    return text.empty() ? "unknown cause" : text;
}

} // namespace

Hdf5Failure::Hdf5Failure() : std::runtime_error(last_error()) {}

std::vector<hsize_t> dimensions(const Extents& extents)
{
    return {extents.begin(), extents.end()};
}

Id make_space(const Extents& extents)
{
    if (extents.empty())
        return {H5Screate(H5S_SCALAR), H5Sclose};
    return {H5Screate_simple(static_cast<int>(extents.size()), dimensions(extents).data(), nullptr),
            H5Sclose};
}

Id open_file(const std::filesystem::path& path)
{
    const Id access(H5Pcreate(H5P_FILE_ACCESS), H5Pclose);
    // Files are replaced as a whole, never changed: readers need no lock.
    checked(H5Pset_file_locking(access, false, true));
    return {H5Fopen(path.c_str(), H5F_ACC_RDONLY, access), H5Fclose};
}

} // namespace shape::internal
