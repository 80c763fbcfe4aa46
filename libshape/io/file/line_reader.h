// SPDX-License-Identifier: MIT

#pragma once

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace shape::internal {

/// The finite double that the whole of `text` spells, in the C locale whatever the environment
/// says; nothing else (no blanks, no hexadecimal, no overflow).
[[nodiscard]] std::optional<double> spelled_number(std::string_view text);

/// The integer that the whole of `text` spells.
[[nodiscard]] std::optional<std::int64_t> spelled_integer(std::string_view text);

/// `text` in quotes for a message: shortened, unprintable bytes as '?'.
[[nodiscard]] std::string in_quotes(std::string_view text);

[[nodiscard]] bool is_utf8(std::string_view text);

/// Reads a text of lines of blank-separated tokens; every error names file and line.
///
/// Lines end with LF or CRLF; the last one may lack it. Refused are byte order marks, NUL bytes, CR
/// elsewhere (old Mac line ends) and lines beyond 1 MiB.
class LineReader
{
public:
    /// @param comment  This character and the rest of its line are skipped; none if NUL.
    LineReader(std::string_view content, std::string path, char comment = '\0');

    /// Goes to the next line that holds a token; false at the end of the text.
    bool next_line();

    /// The next token of the line; empty at its end.
    std::string_view token();
    std::string_view word(std::string_view what); ///< The next token, which must be there.
    double number(std::string_view what);         ///< The next token as a finite number.
    std::int64_t integer(std::string_view what);  ///< The next token as an integer.
    void finish_line();                           ///< There must be no further token.

    [[nodiscard]] bool line_done() const { return rest_.empty(); } ///< No token is left.
    [[nodiscard]] std::string_view line() const { return line_; }
    [[nodiscard]] std::size_t offset() const { return offset_; } ///< Of the line after this one.

    /// @throws InvalidInput always.
    [[noreturn]] void fail(std::string_view rule) const;

private:
    void take_line();

    std::string_view content_;
    std::string path_;
    char comment_;
    std::string_view line_;
    std::string_view rest_;
    std::size_t offset_ = 0;
    std::size_t line_number_ = 0;
};

} // namespace shape::internal
