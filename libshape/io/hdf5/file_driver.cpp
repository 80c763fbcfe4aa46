// SPDX-License-Identifier: MIT

#include "libshape/io/hdf5/file_driver.h"

#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>

#include "libshape/base/to_size.h"

namespace shape::internal {
namespace {

/// What an access list carries.
struct Target
{
    NewFile* file;
};

/// An open file as HDF5 knows it; the first member is HDF5's.
struct DrivenFile
{
    H5FD_t base;
    NewFile* file;
    haddr_t allocated;
    haddr_t end;
};

DrivenFile& of(H5FD_t* file)
{
    return *reinterpret_cast<DrivenFile*>(file);
}
const DrivenFile& of(const H5FD_t* file)
{
    return *reinterpret_cast<const DrivenFile*>(file);
}

/// Runs transfer(bytes done) until it has done `size` bytes or there are no more.
template <class Transfer>
std::size_t transfer_all(NewFile& file, std::size_t size, const Transfer& transfer)
{
    std::size_t done = 0;
    while (done < size && file.error == 0) {
        const ssize_t moved = transfer(done);
        if (moved == 0)
            break;
        if (moved > 0)
            done += to_size(moved);
        else if (errno != EINTR)
            file.error = errno;
    }
    return done;
}

H5FD_t* open_driven(const char*, unsigned, hid_t access, haddr_t)
{
    const auto* target = static_cast<const Target*>(H5Pget_driver_info(access));
    if (target == nullptr)
        return nullptr;
    auto* opened = new DrivenFile{{}, target->file, 0, 0};
    return &opened->base;
}

herr_t close(H5FD_t* file)
{
    delete &of(file);
    return 0;
}

herr_t query(const H5FD_t*, unsigned long* features)
{
    *features = H5FD_FEAT_AGGREGATE_METADATA | H5FD_FEAT_ACCUMULATE_METADATA |
                H5FD_FEAT_DATA_SIEVE | H5FD_FEAT_AGGREGATE_SMALLDATA;
    return 0;
}

herr_t read(H5FD_t* file, H5FD_mem_t, hid_t, haddr_t address, std::size_t size, void* buffer)
{
    DrivenFile& opened = of(file);
    auto* bytes = static_cast<char*>(buffer);
    const std::size_t done = transfer_all(*opened.file, size, [&](std::size_t begin) {
        return ::pread(opened.file->descriptor, bytes + begin, size - begin,
                       static_cast<off_t>(address + begin));
    });
    std::memset(bytes + done, 0, size - done);
    return 0;
}

herr_t write(H5FD_t* file, H5FD_mem_t, hid_t, haddr_t address, std::size_t size, const void* buffer)
{
    DrivenFile& opened = of(file);
    const auto* bytes = static_cast<const char*>(buffer);
    transfer_all(*opened.file, size, [&](std::size_t begin) {
        return ::pwrite(opened.file->descriptor, bytes + begin, size - begin,
                        static_cast<off_t>(address + begin));
    });
    opened.end = std::max(opened.end, address + size);
    return 0;
}

herr_t truncate(H5FD_t* file, hid_t, hbool_t)
{
    DrivenFile& opened = of(file);
    if (opened.file->error == 0 &&
        ::ftruncate(opened.file->descriptor, static_cast<off_t>(opened.allocated)) != 0)
        opened.file->error = errno;
    opened.end = opened.allocated;
    return 0;
}

/// Registered once; HDF5 forgets it when it ends.
hid_t driver()
{
    static const H5FD_class_t functions = [] {
        H5FD_class_t made{};
        made.name = "libshape";
        made.maxaddr = HADDR_MAX / 2;
        made.fc_degree = H5F_CLOSE_WEAK;
        made.fapl_size = sizeof(Target);
        made.open = open_driven;
        made.close = close;
        made.query = query;
        made.get_eoa = [](const H5FD_t* file, H5FD_mem_t) { return of(file).allocated; };
        made.set_eoa = [](H5FD_t* file, H5FD_mem_t, haddr_t address) -> herr_t {
            of(file).allocated = address;
            return 0;
        };
        made.get_eof = [](const H5FD_t* file, H5FD_mem_t) { return of(file).end; };
        made.read = read;
        made.write = write;
        made.truncate = truncate;
        constexpr H5FD_mem_t map[] = H5FD_FLMAP_DICHOTOMY;
        std::copy(std::begin(map), std::end(map), made.fl_map);
        return made;
    }();
    static const hid_t id = checked(H5FDregister(&functions));
    return id;
}

} // namespace

void write_through(hid_t access, NewFile& file)
{
    const Target target{&file};
    checked(H5Pset_driver(access, driver(), &target));
}

} // namespace shape::internal
