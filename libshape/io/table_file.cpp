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

std::string name_of(char separator)
{
    return separator == '\t' ? "a tab" : separator == ' ' ? "a blank" : join("'", separator, "'");
}

/// What is wrong where cells are separated by this.
std::string wrong_separator(char separator)
{
    return join("the separator of the cells is ", name_of(separator),
                ", must be ','; save the table as CSV with commas (and decimal points)");
}

/// Characters that separate cells in files of other programs and occur in names seldom: those of countries with a decimal
/// comma take semicolons, others tabs or bars.
bool is_separator(char c)
{
    return c == ';' || c == '\t' || c == '|';
}

/// Blanks and colons, which occur in names too, and whatever else stands between cells in quotes.
bool may_separate(char c)
{
    const auto byte = static_cast<unsigned char>(c);
    const bool is_word = (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9');
    return byte >= 0x20 && byte < 0x7f && !is_word && c != ',' && c != '"';
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
        quoted_.clear();
        do {
            quoted_.push_back(rest_.starts_with('"') ? 1 : 0);
            cells.push_back(quoted_.back() != 0 ? quoted_cell() : plain_cell(cells.empty()));
        } while (take(","));
        if (take("\n") || take("\r\n") || done()) {
            ++next_line_;
            return cells;
        }
        if (rest_.starts_with('\r'))
            fail("a CR ends no line; lines must end with LF or CRLF");
        if (cells.size() ==
            1) // rows whose first cell ends with a comma have commas, whatever else is wrong
            if (const auto separator = separator_behind_quote())
                fail(wrong_separator(*separator));
        fail(rest_.starts_with(' ') || rest_.starts_with('\t')
                 ? "a blank follows a closing quote; take it away"
                 : "text follows a closing quote");
    }

    /// How often a character stands in a cell of the row that was read last; 0 in quotes, where it is a part of the value.
    [[nodiscard]] std::ptrdiff_t count_unquoted(const Row& row, std::size_t cell, char c) const
    {
        return quoted_[cell] != 0 ? 0 : std::count(row[cell].begin(), row[cell].end(), c);
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

    /// What stands between the cell in quotes that ends here and the next one where commas should; nothing if that cannot
    /// be said.
    [[nodiscard]] std::optional<char> separator_behind_quote() const
    {
        const std::string_view line = rest_.substr(0, rest_.find_first_of("\r\n"));
        const auto first_of = [](std::string_view text) { // that is no blank
            const std::size_t at = text.find_first_not_of(' ');
            return at == std::string_view::npos ? std::string_view() : text.substr(at);
        };
        const std::string_view behind = first_of(line);
        if (behind.empty() || behind.front() == ',') // a stray blank
            return std::nullopt;
        if (is_separator(behind.front()))
            return behind.front();
        if (may_separate(behind.front()) && first_of(behind.substr(1)).starts_with('"'))
            return behind.front();
        const bool is_alone = behind.front() == '"' || line.find(',') == std::string_view::npos;
        if (is_alone && behind.front() == ':')
            return ':';
        return is_alone && line.front() == ' ' ? std::optional(' ') : std::nullopt;
    }

    std::string plain_cell(bool is_first)
    {
        const std::size_t end = std::min(rest_.find_first_of(",\r\n"), rest_.size());
        std::string cell(rest_.substr(0, end));
        if (const std::size_t quote = cell.find('"'); quote != std::string::npos) {
            const std::size_t before = cell.find_last_not_of(' ', quote - 1);
            if (before == std::string::npos) // it does not begin with the quote
                fail("a blank stands before a quote; take it away");
            const bool has_comma = end < rest_.size() && rest_[end] == ',';
            if (is_first && is_separator(cell[before]))
                fail(wrong_separator(cell[before]));
            if (is_first && !has_comma && (before + 1 < quote || cell[before] == ':'))
                fail(wrong_separator(cell[before] == ':' ? ':' : ' '));
            fail(join("a quote stands within the unquoted cell ", in_quotes(cell)));
        }
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
    std::vector<char> quoted_; ///< Which cells of the row were.
};

/// Whether the cells of a row from one on are empty, or blanks.
bool are_empty(const Row& row, std::size_t first)
{
    return std::all_of(
        row.begin() + static_cast<std::ptrdiff_t>(std::min(first, row.size())), row.end(),
        [](const std::string& cell) { return cell.find_first_not_of(" \t") == std::string::npos; });
}

/// What to do about a row that was read last and has another number of cells than the header.
std::string advice_on(const Row& row, const Row& header, const CsvParser& parser)
{
    if (row.size() > header.size())
        return are_empty(row, header.size())
                   ? "; the last is empty: take the comma at the end of the line away (one at the "
                     "end of every line does no harm), or put values that have a comma in quotes"
                   : "; put values that have a comma in quotes, and write numbers with a decimal "
                     "point";
    if (are_empty(row, 0) && row.size() == 1)
        return "; take the empty line away";
    for (const char separator : {';', '\t', '|'}) // as where a part of another table was pasted
        for (std::size_t c = 0; c < row.size(); ++c)
            if (parser.count_unquoted(row, c, separator) > 0)
                return join("; ", name_of(separator),
                            " separates some of them: separate all cells by ','");
    return "; write a comma for each value that is missing";
}

/// Names of columns that may be several, joined by a separator that every row has as often in that place.
class JoinedColumns
{
public:
    /// @param parser  Has read the header last.
    JoinedColumns(const Row& header, const CsvParser& parser)
    {
        if (header.size() > 1)
            for (std::size_t c = 0; c < header.size(); ++c)
                for (const char separator : {';', '\t'})
                    if (const auto count = parser.count_unquoted(header, c, separator); count > 0)
                        joined_.push_back({c, separator, count});
    }

    void take(const Row& row, const CsvParser& parser)
    {
        has_rows_ = true;
        std::erase_if(joined_, [&](const Joined& column) {
            return parser.count_unquoted(row, column.cell, column.separator) != column.count;
        });
    }

    /// @throws InvalidInput if there is one.
    void check(const Row& header, const std::string& path) const
    {
        if (joined_.empty() || !has_rows_)
            return;
        const Joined& first = joined_.front();
        throw InvalidInput(join(path, ": line 1: the column name ", in_quotes(header[first.cell]),
                                " and all cells below it have ", name_of(first.separator),
                                " in them: separate all cells by ',', or put these in quotes if "
                                "they are one value each"));
    }

private:
    struct Joined
    {
        std::size_t cell;
        char separator;
        std::ptrdiff_t count;
    };
    std::vector<Joined> joined_;
    bool has_rows_ = false;
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

/// Of a header of one cell. One with blanks or colons may be a name: then all lines have at least as many.
void check_separator(const Row& columns, std::string_view content, const std::string& path)
{
    if (columns.size() > 1)
        return;
    const std::string& header = columns.front();
    const auto refuse = [&](char separator) {
        throw InvalidInput(join(path, ": line 1: ", wrong_separator(separator)));
    };
    for (const char separator : {';', '\t', '|'})
        if (header.find(separator) != std::string::npos)
            refuse(separator);
    for (const char separator : {':', ' '}) {
        const auto count_in = [separator](std::string_view line) {
            std::size_t count = 0;
            for (std::size_t at = line.find_first_not_of(" \t\r"); at < line.size();) {
                at = std::min(line.find(separator, at), line.size());
                at = std::min(line.find_first_not_of(separator, at), line.size());
                count += at < line.size() && line[at] != '\r' ? 1U : 0U;
            }
            return count;
        };
        const std::size_t wanted = count_in(header);
        std::size_t lines = 0;
        bool is_in_all = wanted > 0;
        for (std::string_view rest = content; is_in_all && !rest.empty();) {
            const std::size_t end = std::min(rest.find('\n'), rest.size());
            const std::string_view line = rest.substr(0, end);
            rest.remove_prefix(std::min(end + 1, rest.size()));
            if (line.find_first_not_of(" \t\r") == std::string_view::npos)
                continue;
            is_in_all = count_in(line) >= wanted;
            ++lines;
        }
        if (is_in_all && lines > 1)
            refuse(separator);
    }
}

/// What to do about a cell that spells no finite number, if that can be told.
std::string_view advice_on_number(std::string_view cell)
{
    if (cell.find(',') != std::string_view::npos)
        return " (decimal point, no comma)";
    if (spells_a_number(cell) && cell.find_first_of("0123456789") != std::string_view::npos)
        return ": double precision ends at 1.8e308; give it in another unit";
    const auto separator = cell.find_first_of("-/.:");
    const bool is_date = cell.find_first_not_of("0123456789-/.:TZ ") == std::string_view::npos &&
                         separator != std::string_view::npos && separator > 0 &&
                         std::count(cell.begin(), cell.end(), cell[separator]) == 2;
    return is_date ? ", but a date or a time; write how long after a beginning it is, such as days"
                   : "";
}

/// @param is_header  Names that may be several to a reader are quoted.
void append_row(std::string& text, const Row& cells, bool is_header = false)
{
    for (std::size_t c = 0; c < cells.size(); ++c) {
        text += c == 0 ? "" : ",";
        const std::string& cell = cells[c];
        // A lone empty cell must not become a blank line.
        const bool is_plain =
            cell.find_first_of(is_header ? ",\"\r\n;\t" : ",\"\r\n") == std::string::npos &&
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
    check_separator(table.columns, content, path.string());
    JoinedColumns joined(table.columns, parser);
    const Row header = table.columns;
    std::size_t width = header.size(); // of the rows; those of some programs all end with a comma
    while (!parser.done()) {
        Row row = parser.row();
        if (table.rows.empty() && row.size() != width && are_empty(row, width) &&
            are_empty(header, row.size()) && rows_have(row.size(), parser))
            width = row.size();
        if (row.size() != width || !are_empty(row, header.size()))
            parser.fail(join("has ", counted(row.size(), "cell"), ", the header has ",
                             header.size(),
                             table.rows.empty() && row.size() == header.size() + 1 &&
                                     !are_empty(row, header.size()) && rows_have(row.size(), parser)
                                 ? ", as have all rows; if their first cells number or name them, "
                                   "write the table without these (R: row.names = FALSE, pandas: "
                                   "index=False)"
                                 : advice_on(row, header, parser)));
        joined.take(row, parser);
        row.resize(header.size());
        table.rows.push_back(std::move(row));
    }
    joined.check(header, path.string());
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
        append_row(text, columns, true);
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
            join(place, ": ", in_quotes(cell), " is not a finite number", advice_on_number(cell)));
    return *value;
}

} // namespace shape
