// SPDX-License-Identifier: MIT

#include "libshape/io/file/line_reader.h"

#include <algorithm>
#include <charconv>
#include <cmath>

#include "libshape/base/error.h"
#include "libshape/base/format.h"
#include "libshape/base/to_size.h"

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

bool spells_a_number(std::string_view text)
{
    text = without_plus(text);
    double value{};
    const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
    return error != std::errc::invalid_argument && end == text.data() + text.size();
}

std::optional<std::int64_t> spelled_integer(std::string_view text)
{
    return spelled<std::int64_t>(text);
}

std::string_view broken_rule_of_integer(std::string_view text)
{
    text.remove_prefix(text.starts_with('+') || text.starts_with('-') ? 1 : 0);
    return !text.empty() && text.find_first_not_of("0123456789") == std::string_view::npos
               ? "is beyond what can be counted, 2^63 - 1"
               : "must be an integer";
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
    if (content.starts_with("\xFF\xFE") || content.starts_with("\xFE\xFF"))
        fail("starts with the byte order mark of UTF-16; save the file as UTF-8 or ASCII text");
    if (content.starts_with("\xEF\xBB\xBF"))
        offset_ = 3;
    const std::size_t first_end = content.substr(0, longest_line + 2).find_first_of("\r\n");
    if (first_end != std::string_view::npos && content[first_end] == '\r' &&
        content.substr(first_end + 1, 1) != "\n")
        line_end_ = '\r';
    line_number_ = 0;
}

void LineReader::take_line()
{
    ++line_number_;
    const std::string_view window = content_.substr(offset_, longest_line + 1);
    const std::size_t end = window.find(line_end_);
    std::string_view line = window.substr(0, end);
    if (line.size() > longest_line)
        fail(join("is longer than ", longest_line, " bytes"));
    offset_ += line.size() + (end == std::string_view::npos ? 0 : 1);
    if (line_end_ == '\n' && line.ends_with('\r'))
        line.remove_suffix(1);
    if (line.find('\0') != std::string_view::npos)
        fail("holds a NUL byte; a binary or UTF-16 file is not text");
    if (line.find(line_end_ == '\n' ? '\r' : '\n') != std::string_view::npos)
        fail("holds a CR that ends no line; lines must all end with LF, CRLF or CR");
    rest_ = comment_ == '\0' ? line : line.substr(0, line.find(comment_));
}

void LineReader::skip_blanks()
{
    while (!rest_.empty() && is_blank(rest_.front()))
        rest_.remove_prefix(1);
}

bool LineReader::is_continued() const
{
    const std::size_t last = rest_.find_last_not_of(" \t\v\f");
    return last != std::string_view::npos && rest_[last] == '\\';
}

void LineReader::join_next_line()
{
    std::string_view before = rest_.substr(0, rest_.find_last_of('\\'));
    // Appended in place, so that many short lines cost no more than one long one.
    const bool is_joined = !joined_.empty() && before.data() >= joined_.data() &&
                           before.data() <= joined_.data() + joined_.size();
    const std::size_t begin = is_joined ? to_size(before.data() - joined_.data()) : 0;
    if (is_joined)
        joined_.resize(begin + before.size());
    else
        joined_.assign(before);
    if (offset_ < content_.size()) {
        take_line();
        joined_ += ' ';
        joined_ += rest_;
    }
    if (joined_.size() > longest_line)
        fail(join("is longer than ", longest_line, " bytes with the lines that continue it"));
    rest_ = std::string_view(joined_).substr(begin);
    skip_blanks();
}

std::string_view LineReader::next_keyword() const
{
    std::string_view text = content_.substr(offset_, longest_line);
    text = text.substr(0, text.find_first_of("\r\n"));
    text.remove_prefix(std::min(text.find_first_not_of(" \t\v\f"), text.size()));
    return text.substr(0, text.find_first_of(" \t\v\f"));
}

bool LineReader::next_line()
{
    while (offset_ < content_.size()) {
        take_line();
        skip_blanks();
        if (!rest_.empty())
            return true;
    }
    rest_ = {};
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
        fail(join(what, " is ", in_quotes(text), ", ", broken_rule_of_integer(text)));
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
