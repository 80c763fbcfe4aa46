// SPDX-License-Identifier: MIT

#include "libshape/io/file/free_places.h"

#include <mutex>
#include <set>

namespace shape::internal {
namespace {

/// Those of all objects of the process.
struct Known
{
    std::mutex mutex;
    std::multiset<std::string> paths;
};

Known& known()
{
    static Known all;
    return all;
}

/// One spelling of a path, without a slash at its end.
std::string key_of(const std::filesystem::path& path)
{
    const std::filesystem::path plain = std::filesystem::absolute(path).lexically_normal();
    return (plain.has_filename() ? plain : plain.parent_path()).string();
}

} // namespace

FreePlaces::~FreePlaces()
{
    const std::lock_guard lock(known().mutex);
    for (const std::string& path : paths_)
        if (const auto found = known().paths.find(path); found != known().paths.end())
            known().paths.erase(found);
}

void FreePlaces::add(const std::filesystem::path& path)
{
    const std::lock_guard lock(known().mutex);
    paths_.push_back(key_of(path));
    known().paths.insert(paths_.back());
}

bool FreePlaces::contain(const std::filesystem::path& path)
{
    const std::lock_guard lock(known().mutex);
    return known().paths.contains(key_of(path));
}

void FreePlaces::remove(const std::filesystem::path& path)
{
    const std::lock_guard lock(known().mutex);
    known().paths.erase(key_of(path));
}

} // namespace shape::internal
