// SPDX-License-Identifier: MIT

#include "libshape/io/file/line_reader.h"

#include <charconv>
#include <cmath>

#include "libshape/base/error.h"
#include "libshape/base/format.h"

namespace shape::internal {
namespace {

constexpr std::size_t longest_line = 1 << 20;

bool is_blank(char c)
{
    return c == ' ' || c == '\t' || c == '\v' || c == '\f';
}

/// std::from_chars does not take a leading plus sign.
std::string_view without_plus(std::string_view text)
{
    return text.size() > 1 && text[0] == '+' && text[1] != '-' ? text.substr(1) : text;
}

template <class Value>
std::optional<Value> spelled(std::string_view text)
{
    text = without_plus(text);
    Value value{};
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    if (error != std::errc() || end != text.data() + text.size())
        return std::nullopt;
    return value;
}

} // namespace

std::optional<double> spelled_number(std::string_view text)
{
    const std::optional<double> value = spelled<double>(text);
    return value && std::isfinite(*value) ? value : std::nullopt; // from_chars reads "nan"
}

std::optional<std::int64_t> spelled_integer(std::string_view text)
{
    return spelled<std::int64_t>(text);
}

std::string in_quotes(std::string_view text)
{
    constexpr std::size_t longest = 40;
    std::string out = "'";
    for (const char c : text.substr(0, longest))
        out += static_cast<unsigned char>(c) < 0x20 || c == 0x7f ? '?' : c;
    return out + (text.size() > longest ? "...'" : "'");
}

bool is_utf8(std::string_view text)
{
    for (std::size_t i = 0; i < text.size();) {
        const auto lead = static_cast<unsigned char>(text[i]);
        const std::size_t size = lead < 0x80 ? 1 : lead < 0xe0 ? 2 : lead < 0xf0 ? 3 : 4;
        if ((lead >= 0x80 && lead < 0xc2) || lead > 0xf4 || text.size() - i < size)
            return false;
        for (std::size_t k = 1; k < size; ++k)
            if ((static_cast<unsigned char>(text[i + k]) & 0xc0) != 0x80)
                return false;
        if (size > 2) { // overlong forms, surrogates, beyond U+10FFFF
            const auto second = static_cast<unsigned char>(text[i + 1]);
            if ((lead == 0xe0 && second < 0xa0) || (lead == 0xed && second > 0x9f) ||
                (lead == 0xf0 && second < 0x90) || (lead == 0xf4 && second > 0x8f))
                return false;
        }
        i += size;
    }
    return true;
}

LineReader::LineReader(std::string_view content, std::string path, char comment)
    : content_(content), path_(std::move(path)), comment_(comment)
{
    line_number_ = 1;
    if (content.empty())
        throw InvalidInput(path_ + ": the file is empty");
    if (content.starts_with("\xEF\xBB\xBF") || content.starts_with("\xFF\xFE") ||
        content.starts_with("\xFE\xFF"))
        fail("starts with a byte order mark; save the file as plain text without one");
    line_number_ = 0;
}

void LineReader::take_line()
{
    ++line_number_;
    const std::string_view window = content_.substr(offset_, longest_line + 1);
    const std::size_t end = window.find('\n');
    line_ = window.substr(0, end);
    if (line_.size() > longest_line)
        fail(join("is longer than ", longest_line, " bytes"));
    offset_ += line_.size() + (end == std::string_view::npos ? 0 : 1);
    if (line_.ends_with('\r'))
        line_.remove_suffix(1);
    if (line_.find('\0') != std::string_view::npos)
        fail("holds a NUL byte; a binary or UTF-16 file is not text");
    if (line_.find('\r') != std::string_view::npos)
        fail("holds a CR that ends no line; lines must end with LF or CRLF");
    rest_ = comment_ == '\0' ? line_ : line_.substr(0, line_.find(comment_));
}

bool LineReader::next_line()
{
    while (offset_ < content_.size()) {
        take_line();
        while (!rest_.empty() && is_blank(rest_.front()))
            rest_.remove_prefix(1);
        if (!rest_.empty())
            return true;
    }
    line_ = rest_ = {};
    return false;
}

std::string_view LineReader::token()
{
    std::size_t end = 0;
    while (end < rest_.size() && !is_blank(rest_[end]))
        ++end;
    const std::string_view found = rest_.substr(0, end);
    while (end < rest_.size() && is_blank(rest_[end]))
        ++end;
    rest_.remove_prefix(end);
    return found;
}

std::string_view LineReader::word(std::string_view what)
{
    const std::string_view found = token();
    if (found.empty())
        fail(join(what, " is missing"));
    return found;
}

double LineReader::number(std::string_view what)
{
    const std::string_view text = word(what);
    const std::optional<double> value = spelled_number(text);
    if (!value)
        fail(join(what, " is ", in_quotes(text), ", must be a finite number"));
    return *value;
}

std::int64_t LineReader::integer(std::string_view what)
{
    const std::string_view text = word(what);
    const std::optional<std::int64_t> value = spelled_integer(text);
    if (!value)
        fail(join(what, " is ", in_quotes(text), ", must be an integer"));
    return *value;
}

void LineReader::finish_line()
{
    if (!rest_.empty())
        fail(join("unexpected ", in_quotes(token()), " at the end of the line"));
}

void LineReader::fail(std::string_view rule) const
{
    throw InvalidInput(join(path_, ": line ", line_number_, ": ", rule));
}

} // namespace shape::internal
