// SPDX-License-Identifier: MIT

#include "libshape/io/index_file.h"

#include <string>

#include "libshape/base/error.h"
#include "libshape/base/format.h"
#include "libshape/io/file/input_file.h"
#include "libshape/io/file/line_reader.h"

namespace shape::internal {
namespace {

constexpr std::uint64_t largest_index_file = std::uint64_t{1} << 30;

} // namespace

std::vector<int> read_indices(const std::filesystem::path& path, int count, std::string_view what)
{
    const std::string content = read_file(path, largest_index_file);
    LineReader reader(content, path.string(), '#');
    std::vector<int> indices;
    while (reader.next_line())
        while (!reader.line_done()) {
            const std::int64_t index = reader.integer(what);
            if (index < 0 || index >= count)
                reader.fail(join(what, " ", index, " is out of range [0, ", count - 1, "]"));
            indices.push_back(static_cast<int>(index));
        }
    if (indices.empty())
        throw InvalidInput(join(path.string(), ": the file holds no ", what));
    return indices;
}

} // namespace shape::internal
