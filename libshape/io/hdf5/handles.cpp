// SPDX-License-Identifier: MIT

#include "libshape/io/hdf5/handles.h"

#include <new>
#include <string>

#include "libshape/base/memory_limit.h"

namespace shape::internal {
namespace {

/// HDF5's last error.
struct LastError
{
    std::string text; ///< As the innermost function put it.
    bool is_allocation = false;
};

LastError last_error()
{
    LastError last;
    const auto take = [](unsigned n, const H5E_error2_t* error, void* out) -> herr_t {
        auto& found = *static_cast<LastError*>(out);
        if (n == 0 && error->desc != nullptr)
            found.text = error->desc;
        found.is_allocation = found.is_allocation ||
                              (error->maj_num == H5E_RESOURCE &&
                               (error->min_num == H5E_NOSPACE || error->min_num == H5E_CANTALLOC));
        return 0;
    };
    H5Ewalk2(H5E_DEFAULT, H5E_WALK_UPWARD, take, &last);
    return last;
}

} // namespace

void throw_last_failure()
{
    const LastError last = last_error();
    // Where nothing is left HDF5 cannot even keep its error.
    if ((last.is_allocation || last.text.empty()) && is_memory_limited())
        throw std::bad_alloc();
    throw Hdf5Failure(last.text.empty() ? "unknown cause" : last.text);
}

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
