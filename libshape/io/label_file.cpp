// SPDX-License-Identifier: MIT

#include "libshape/io/label_file.h"

#include <utf8proc.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <map>
#include <memory>

#include "libshape/base/error.h"
#include "libshape/base/format.h"
#include "libshape/base/letter_case.h"
#include "libshape/base/to_size.h"
#include "libshape/io/file/line_reader.h"
#include "libshape/io/mesh_endings.h"
#include "libshape/io/table_file.h"

namespace shape {
using namespace internal;
namespace {

/// Stands for a key that several meshes have.
constexpr std::size_t ambiguous = to_size(-1);

/// Blanks of ASCII, and those that are pasted from web pages and documents.
std::string_view without_outer_blanks(std::string_view text)
{
    constexpr std::array<std::string_view, 10> blanks = {
        " ",  "\t",       "\r",           "\n",           "\v",
        "\f", "\xC2\xA0", "\xEF\xBB\xBF", "\xE2\x80\x8B", "\xE3\x80\x80"};
    for (bool again = true; again;) {
        again = false;
        for (const std::string_view blank : blanks) {
            if (text.starts_with(blank)) {
                text.remove_prefix(blank.size());
                again = true;
            } else if (text.ends_with(blank)) {
                text.remove_suffix(blank.size());
                again = true;
            }
        }
    }
    return text;
}

/// Unicode NFC; text that cannot be composed stays as it is.
std::string composed(std::string_view text)
{
    if (std::all_of(text.begin(), text.end(), [](char c) { return (c & 0x80) == 0; }) ||
        !is_utf8(text))
        return std::string(text);
    utf8proc_uint8_t* composed = nullptr;
    const utf8proc_ssize_t length =
        utf8proc_map(reinterpret_cast<const utf8proc_uint8_t*>(text.data()),
                     static_cast<utf8proc_ssize_t>(text.size()), &composed,
                     static_cast<utf8proc_option_t>(UTF8PROC_STABLE | UTF8PROC_COMPOSE));
    const std::unique_ptr<utf8proc_uint8_t, decltype(&std::free)> owner(composed, &std::free);
    return length < 0 ? std::string(text)
                      : std::string(reinterpret_cast<const char*>(composed), to_size(length));
}

/// What names of one mesh have in common.
std::string key_of(std::string_view name)
{
    name = without_mesh_ending(without_outer_blanks(name));
    return composed(without_outer_blanks(name));
}

bool is_blank(const std::vector<std::string>& row)
{
    return std::all_of(row.begin(), row.end(),
                       [](const auto& cell) { return without_outer_blanks(cell).empty(); });
}

/// Finds meshes by their names as tables spell them.
class NameIndex
{
public:
    explicit NameIndex(const std::vector<std::string>& names)
    {
        for (std::size_t i = 0; i < names.size(); ++i) {
            exact_.emplace(names[i], i);
            const auto [place, is_new] = by_key_.emplace(key_of(names[i]), i);
            if (!is_new)
                place->second = ambiguous;
        }
    }
    /// @return The mesh; `ambiguous`; or nothing.
    [[nodiscard]] std::optional<std::size_t> find(const std::string& name) const
    {
        if (const auto found = exact_.find(name); found != exact_.end())
            return found->second;
        if (const auto found = by_key_.find(key_of(name)); found != by_key_.end())
            return found->second;
        return std::nullopt;
    }

private:
    std::map<std::string, std::size_t> exact_;
    std::map<std::string, std::size_t> by_key_;
};

} // namespace

std::string label_value(std::string_view cell)
{
    constexpr std::array<std::string_view, 24> missing = {
        "",     "na",       "n/a",       "#n/a",    "#n/a n/a", "#na",    "<na>",    "nan",
        "-nan", "nan(ind)", "-nan(ind)", "1.#qnan", "-1.#qnan", "1.#ind", "-1.#ind", "nat",
        "null", "#null!",   "#div/0!",   "#value!", "#ref!",    "#name?", "#num!",   "#nv"};
    const std::string_view text = without_outer_blanks(cell);
    if (text == "." || std::find(missing.begin(), missing.end(), lower_case(text)) != missing.end())
        return {};
    return composed(text);
}

std::optional<std::pair<std::size_t, std::size_t>> names_alike(
    const std::vector<std::string>& names)
{
    std::map<std::string, std::size_t> first;
    for (std::size_t i = 0; i < names.size(); ++i) {
        const std::size_t known = first.try_emplace(key_of(names[i]), i).first->second;
        if (names[known] != names[i])
            return std::pair{known, i};
    }
    return std::nullopt;
}

std::string label_name(std::string_view column)
{
    return composed(without_outer_blanks(column));
}

bool is_storable_label(std::string_view name)
{
    return !name.empty() && name.find('\0') == std::string_view::npos;
}

Table read_label_table(const std::filesystem::path& path)
{
    Table table = read_table(path);
    std::map<std::string, std::string> spelled;
    for (std::string& column : table.columns) {
        std::string name = label_name(column);
        const auto [known, is_new] = spelled.try_emplace(name, column);
        if (!is_new && !name.empty())
            throw InvalidInput(join(path.string(), ": line 1: the columns ",
                                    in_quotes(known->second), " and ", in_quotes(column),
                                    " have one name but for blanks or the composition of accents; "
                                    "rename one of them"));
        column = std::move(name);
    }
    std::erase_if(table.rows, is_blank); // as spreadsheets write below a table
    return table;
}

LabelFile read_label_file(const std::filesystem::path& path, const std::vector<std::string>& names)
{
    const Table table = read_label_table(path);
    const auto fail = [&](const auto&... parts) {
        throw InvalidInput(join(path.string(), ": ", parts...));
    };
    if (table.columns.front() != "mesh")
        fail("the first column is ", in_quotes(table.columns.front()),
             ", must be 'mesh' (the names of the mesh files)");
    const NameIndex index(names);
    LabelFile result;
    std::vector<const std::vector<std::string>*> row_of(names.size(), nullptr);
    for (const std::vector<std::string>& row : table.rows) {
        const std::optional<std::size_t> mesh = index.find(row.front());
        if (!mesh) {
            result.unused.push_back(row.front());
            continue;
        }
        if (*mesh == ambiguous)
            fail(
                "mesh ", in_quotes(row.front()),
                " could be several meshes, whose names differ by blanks, endings or accents alone");
        if (row_of[*mesh] != nullptr)
            fail("mesh ", in_quotes(row.front()), " occurs twice");
        row_of[*mesh] = &row;
    }
    std::vector<std::size_t> columns; // that have a name
    for (std::size_t c = 1; c < table.columns.size(); ++c)
        (table.columns[c].empty() ? result.nameless : columns).push_back(c);
    for (const std::size_t c : columns)
        result.labels.push_back({table.columns[c], {}});
    for (std::size_t i = 0; i < names.size(); ++i) {
        if (row_of[i] == nullptr)
            fail("mesh ", in_quotes(names[i]), " is missing",
                 result.unused.empty()
                     ? std::string()
                     : join("; the table has names that no mesh has, first ",
                            in_quotes(result.unused.front()), ": are they spelled alike?"));
        for (std::size_t k = 0; k < columns.size(); ++k)
            result.labels[k].values.push_back(label_value((*row_of[i])[columns[k]]));
    }
    return result;
}

} // namespace shape
