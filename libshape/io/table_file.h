// SPDX-License-Identifier: MIT

#pragma once

#include <filesystem>
#include <string>
#include <vector>

namespace shape {

/// A CSV file: one header row and rows of as many cells.
struct Table
{
    std::vector<std::string> columns;           ///< Unique, not empty.
    std::vector<std::vector<std::string>> rows; ///< Each as long as columns.
};

/// Reads RFC 4180 CSV (UTF-8, a byte order mark is skipped, LF or CRLF). Last columns without a name and
/// without any value, and a first line `sep=,`, are passed over: spreadsheets write them.
/// @throws FileError if it cannot be read.
/// @throws InvalidInput naming the line for ragged rows, unclosed quotes, empty or repeated
///     column names, or cells separated by something else than commas: semicolons, tabs, bars, colons, blanks; in quotes
///     any character.
[[nodiscard]] Table read_table(const std::filesystem::path& path);

/// RFC 4180 with LF line ends; cells are quoted where they must be. The file appears whole or not at all: it is written beside, synced and renamed.
/// @throws InvalidInput if a column name is empty or repeated, or a row has another number of cells.
/// @throws FileError if it cannot be written.
void write_table(const std::filesystem::path& path, const Table& table);

/// The shortest digits that give the double back.
[[nodiscard]] std::string print_number(double value);

/// The finite number that the whole cell spells.
/// @throws InvalidInput if it is none; `place` starts the message.
[[nodiscard]] double parse_number(const std::string& cell, const std::string& place);

} // namespace shape
