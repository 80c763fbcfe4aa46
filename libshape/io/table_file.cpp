// SPDX-License-Identifier: MIT

#include "libshape/io/table_file.h"

#include <algorithm>
#include <optional>
#include <set>

#include "libshape/base/counted.h"
#include "libshape/base/error.h"
#include "libshape/base/format.h"
#include "libshape/base/to_size.h"
#include "libshape/io/file/input_file.h"
#include "libshape/io/file/line_reader.h"
#include "libshape/io/file/long_output.h"
#include "libshape/io/long_table.h"
#include "libshape/io/mesh_formats.h"

namespace shape {
using namespace internal;
namespace {

constexpr std::uint64_t largest_table = std::uint64_t{2} << 30;

using Row = std::vector<std::string>;

/// What is wrong if cells are separated by this. Programs in countries with a decimal comma take semicolons, others tabs.
std::optional<std::string> wrong_separator(char separator)
{
    if (separator != ';' && separator != '\t')
        return std::nullopt;
    return join("the separator of the cells is ", separator == ';' ? "';'" : "a tab",
                ", must be ','; save the table as CSV with commas (and decimal points)");
}

/// Splits CSV into rows; knows the line for messages.
class CsvParser
{
public:
    CsvParser(std::string_view content, std::string path) : rest_(content), path_(std::move(path))
    {
        if (rest_.starts_with("\xEF\xBB\xBF"))
            rest_.remove_prefix(3);
        for (const std::string_view line : {"sep=,\n", "sep=,\r\n"}) // what spreadsheets put first
            if (rest_.starts_with(line)) {
                rest_.remove_prefix(line.size());
                next_line_ = 2;
            }
        while (rest_.ends_with('\n')) // blank lines at the end, too
            rest_.remove_suffix(rest_.ends_with("\r\n") ? 2 : 1);
        if (rest_.find('\0') != std::string_view::npos || !is_utf8(rest_))
            throw InvalidInput(path_ + ": the file is not UTF-8 text; save it as CSV in UTF-8");
    }

    [[nodiscard]] bool done() const { return rest_.empty(); }

    /// The next row; `line` is where it starts.
    Row row()
    {
        line_ = next_line_;
        Row cells;
        do
            cells.push_back(rest_.starts_with('"') ? quoted_cell() : plain_cell(cells.empty()));
        while (take(","));
        if (take("\n") || take("\r\n") || done()) {
            ++next_line_;
            return cells;
        }
        if (rest_.starts_with('\r'))
            fail("a CR ends no line; lines must end with LF or CRLF");
        fail(separator_behind_first(cells.size() == 1, rest_.front())
                 .value_or("text follows a closing quote"));
    }

    [[noreturn]] void fail(std::string_view rule) const
    {
        throw InvalidInput(join(path_, ": line ", line_, ": ", rule));
    }

private:
    bool take(std::string_view text)
    {
        const bool is_there = rest_.starts_with(text);
        if (is_there)
            rest_.remove_prefix(text.size());
        return is_there;
    }

    /// Rows whose first cell ends with a comma have commas, whatever else is wrong.
    static std::optional<std::string> separator_behind_first(bool is_first, char character)
    {
        return is_first ? wrong_separator(character) : std::nullopt;
    }

    std::string plain_cell(bool is_first)
    {
        const std::size_t end = std::min(rest_.find_first_of(",\r\n"), rest_.size());
        std::string cell(rest_.substr(0, end));
        if (const std::size_t quote = cell.find('"'); quote != std::string::npos)
            fail(separator_behind_first(is_first, cell[quote - 1]) // it does not begin with one
                     .value_or(join("a quote stands within the unquoted cell ", in_quotes(cell))));
        rest_.remove_prefix(end);
        return cell;
    }

    std::string quoted_cell()
    {
        rest_.remove_prefix(1);
        std::string cell;
        for (;;) {
            const std::size_t end = rest_.find('"');
            if (end == std::string_view::npos)
                fail("a quote is not closed");
            cell += rest_.substr(0, end);
            rest_.remove_prefix(end + 1);
            if (!take("\""))
                break;
            cell += '"';
        }
        next_line_ += to_size(std::count(cell.begin(), cell.end(), '\n'));
        return cell;
    }

    std::string_view rest_;
    std::string path_;
    std::size_t line_ = 1;
    std::size_t next_line_ = 1;
};

/// Whether all rows that are left have so many cells.
bool rows_have(std::size_t cells, CsvParser parser)
{
    try {
        while (!parser.done())
            if (parser.row().size() != cells)
                return false;
    } catch (const InvalidInput&) {
        return false; // of a later line; the first one is to be told of
    }
    return true;
}

void check_columns(const Row& columns, const std::string& place)
{
    std::set<std::string> seen;
    for (std::size_t c = 0; c < columns.size(); ++c) {
        if (columns[c].empty())
            throw InvalidInput(join(place, "column ", c + 1, " has no name",
                                    c == 0
                                        ? "; if it numbers or names the rows, write the table "
                                          "without it (R: row.names = FALSE, pandas: index=False)"
                                        : ""));
        if (!seen.insert(columns[c]).second)
            throw InvalidInput(join(place, "column name ", in_quotes(columns[c]), " occurs twice"));
    }
}

/// Spreadsheets write columns that were used once: without a name and a value they are none.
void drop_blank_columns(Table& table)
{
    const auto is_blank = [](const Row& row) { return row.back().empty(); };
    while (table.columns.size() > 1 && table.columns.back().empty() &&
           std::all_of(table.rows.begin(), table.rows.end(), is_blank)) {
        table.columns.pop_back();
        for (Row& row : table.rows)
            row.pop_back();
    }
}

void check_separator(const Row& columns, const std::string& path)
{
    if (columns.size() > 1)
        return;
    for (const char separator : {';', '\t'})
        if (columns.front().find(separator) != std::string::npos)
            throw InvalidInput(join(path, ": line 1: ", *wrong_separator(separator)));
}

void append_row(std::string& text, const Row& cells)
{
    for (std::size_t c = 0; c < cells.size(); ++c) {
        text += c == 0 ? "" : ",";
        const std::string& cell = cells[c];
        // A lone empty cell must not become a blank line.
        const bool is_plain = cell.find_first_of(",\"\r\n") == std::string::npos &&
                              !(cell.empty() && cells.size() == 1);
        if (is_plain) {
            text += cell;
            continue;
        }
        text += '"';
        for (const char character : cell)
            text.append(character == '"' ? 2 : 1, character);
        text += '"';
    }
    text += '\n';
}

} // namespace

Table read_table(const std::filesystem::path& path)
{
    const std::string content = read_file(path, largest_table);
    CsvParser parser(content, path.string());
    if (parser.done())
        throw InvalidInput(path.string() + ": the file is empty; a table needs a header row");
    Table table;
    table.columns = parser.row();
    check_separator(table.columns, path.string());
    while (!parser.done()) {
        Row row = parser.row();
        if (row.size() != table.columns.size())
            parser.fail(join("has ", counted(row.size(), "cell"), ", the header has ",
                             table.columns.size(),
                             table.rows.empty() && row.size() == table.columns.size() + 1 &&
                                     rows_have(row.size(), parser)
                                 ? ", as have all rows; if their first cells number or name them, "
                                   "write the table without these (R: row.names = FALSE, pandas: "
                                   "index=False)"
                                 : ""));
        table.rows.push_back(std::move(row));
    }
    drop_blank_columns(table);
    check_columns(table.columns, path.string() + ": line 1: ");
    return table;
}

void write_table(const std::filesystem::path& path, const Table& table)
{
    write_long_table(path, table.columns, [&](const auto& add) {
        for (const Row& row : table.rows)
            add(row);
    });
}

void write_long_table(const std::filesystem::path& path, const std::vector<std::string>& columns,
                      const std::function<void(const std::function<void(const Row&)>&)>& make_rows)
{
    check_columns(columns, "table: ");
    constexpr std::size_t piece = std::size_t{1} << 20;
    write_pieces_atomically(path, [&](const AppendText& append) {
        std::string text;
        append_row(text, columns);
        std::size_t count = 0;
        make_rows([&](const Row& row) {
            if (row.size() != columns.size())
                throw InvalidInput(join("table: row ", count, " has ", counted(row.size(), "cell"),
                                        ", must have ", columns.size()));
            ++count;
            append_row(text, row);
            if (text.size() < piece)
                return;
            append(text);
            text.clear();
        });
        append(text);
    });
}

std::string print_number(double value)
{
    std::string text;
    append_number(text, value);
    return text;
}

double parse_number(const std::string& cell, const std::string& place)
{
    const std::optional<double> value = spelled_number(cell);
    if (!value)
        throw InvalidInput(
            join(place, ": ", in_quotes(cell), " is not a finite number",
                 cell.find(',') == std::string::npos ? "" : " (decimal point, no comma)"));
    return *value;
}

} // namespace shape
