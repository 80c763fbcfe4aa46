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

/// Whether the whole of `text` spells a number, be it infinite or none ("nan"): what stands beside
/// the geometry and is not kept.
[[nodiscard]] bool spells_a_number(std::string_view text);

/// The integer that the whole of `text` spells.
[[nodiscard]] std::optional<std::int64_t> spelled_integer(std::string_view text);

/// What a text that spelled_integer() does not take breaks: "must be an integer", or, of one that is, that it is too large.
[[nodiscard]] std::string_view broken_rule_of_integer(std::string_view text);

/// `text` in quotes for a message: shortened, unprintable bytes as '?'.
[[nodiscard]] std::string in_quotes(std::string_view text);

[[nodiscard]] bool is_utf8(std::string_view text);

/// Reads a text of lines of blank-separated tokens; every error names file and line.
///
/// Lines end with LF or CRLF, or all of them with CR (old Macs) if the first one does; the last one
/// may lack its end. A UTF-8 byte order mark is skipped. Refused are UTF-16, NUL bytes, a CR that ends
/// no line, and lines beyond 1 MiB.
class LineReader
{
public:
    /// @param comment  This character and the rest of its line are skipped; none if NUL.
    LineReader(std::string_view content, std::string path, char comment = '\0');

    /// Goes to the next line that holds a token; false at the end of the text.
    bool next_line();

    /// Whether the line ends with a backslash, which some formats continue it by.
    [[nodiscard]] bool is_continued() const;
    /// Replaces that backslash by the content of the next line; where there is none, it is dropped.
    void join_next_line();
    /// The first token of the line after this one; empty if it has none.
    [[nodiscard]] std::string_view next_keyword() const;

    /// The next token of the line; empty at its end.
    std::string_view token();
    std::string_view word(std::string_view what); ///< The next token, which must be there.
    double number(std::string_view what);         ///< The next token as a finite number.
    std::int64_t integer(std::string_view what);  ///< The next token as an integer.
    void finish_line();                           ///< There must be no further token.

    [[nodiscard]] bool line_done() const { return rest_.empty(); } ///< No token is left.
    [[nodiscard]] std::string_view rest() const { return rest_; }  ///< What is left of the line.
    /// Where the line after this one begins.
    [[nodiscard]] std::size_t offset() const { return offset_; }

    /// @throws InvalidInput always.
    [[noreturn]] void fail(std::string_view rule) const;

private:
    void take_line();
    void skip_blanks();

    std::string_view content_;
    std::string path_;
    char comment_;
    char line_end_ = '\n';
    std::string joined_; ///< What rest_ looks into once lines were joined.
    std::string_view rest_;
    std::size_t offset_ = 0;
    std::size_t line_number_ = 0;
};

} // namespace shape::internal
