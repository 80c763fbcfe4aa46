// SPDX-License-Identifier: MIT

#include "libshape/io/label_doubts.h"

#include <utf8proc.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <cstdlib>
#include <limits>
#include <map>
#include <memory>
#include <numeric>
#include <set>

#include "libshape/base/counted.h"
#include "libshape/base/format.h"
#include "libshape/base/letter_case.h"
#include "libshape/base/to_size.h"
#include "libshape/io/file/line_reader.h"
#include "libshape/io/label_file.h"
#include "libshape/io/table_file.h"
#include "libshape/mesh/oddities.h"

namespace shape::internal {
namespace {

using CodePoint = utf8proc_int32_t;

/// A blank for what ends lines or columns; the Latin letter whose capital has the form of this Greek or Cyrillic one, but
/// for mu, whose small letter stands for a unit; else the same.
CodePoint plain_form(CodePoint code, void*)
{
    if (utf8proc_category(code) == UTF8PROC_CATEGORY_CC)
        return ' ';
    static const std::map<CodePoint, char> twins = {
        {0x391, 'A'}, {0x392, 'B'}, {0x395, 'E'}, {0x396, 'Z'}, {0x397, 'H'}, {0x399, 'I'},
        {0x39A, 'K'}, {0x39D, 'N'}, {0x39F, 'O'}, {0x3A1, 'P'}, {0x3A4, 'T'}, {0x3A5, 'Y'},
        {0x3A7, 'X'}, {0x405, 'S'}, {0x406, 'I'}, {0x408, 'J'}, {0x410, 'A'}, {0x412, 'B'},
        {0x415, 'E'}, {0x41A, 'K'}, {0x41C, 'M'}, {0x41D, 'H'}, {0x41E, 'O'}, {0x420, 'P'},
        {0x421, 'C'}, {0x422, 'T'}, {0x423, 'Y'}, {0x425, 'X'}};
    const auto found = twins.find(utf8proc_toupper(code));
    return found == twins.end() ? code : found->second;
}

/// Text as utf8proc maps it; in lower case of ASCII where it cannot.
std::string mapped(const std::string& text, int options, utf8proc_custom_func custom)
{
    utf8proc_uint8_t* result = nullptr;
    const utf8proc_ssize_t length =
        utf8proc_map_custom(reinterpret_cast<const utf8proc_uint8_t*>(text.data()),
                            static_cast<utf8proc_ssize_t>(text.size()), &result,
                            static_cast<utf8proc_option_t>(options), custom, nullptr);
    const std::unique_ptr<utf8proc_uint8_t, decltype(&std::free)> owner(result, &std::free);
    return length < 0 ? lower_case(text)
                      : std::string(reinterpret_cast<const char*>(result), to_size(length));
}

std::string without_case(const std::string& text)
{
    return mapped(text, UTF8PROC_STABLE | UTF8PROC_COMPOSE | UTF8PROC_CASEFOLD, nullptr);
}

/// Without the quotes, and the = before them, that spreadsheets put around what they are to take as text.
std::string without_marks_of_text(const std::string& look)
{
    const auto is_inner = [](char c) { return c != '\'' && c != '"'; };
    const std::size_t equals = look.starts_with("=\"") ? 1 : 0;
    const auto begin =
        std::find_if(look.begin() + static_cast<std::ptrdiff_t>(equals), look.end(), is_inner);
    const auto end =
        std::find_if(look.rbegin(), std::make_reverse_iterator(begin), is_inner).base();
    return begin == end ? look : std::string(begin, end);
}

/// What texts that look alike have in common.
std::string look_of(const std::string& text)
{
    std::string look = mapped(text,
                              UTF8PROC_STABLE | UTF8PROC_COMPOSE | UTF8PROC_COMPAT |
                                  UTF8PROC_CASEFOLD | UTF8PROC_IGNORE | UTF8PROC_LUMP,
                              plain_form);
    const auto are_blanks = [](char a, char b) { return a == ' ' && b == ' '; };
    look.erase(std::unique(look.begin(), look.end(), are_blanks), look.end());
    return without_marks_of_text(look);
}

std::vector<CodePoint> code_points(const std::string& text)
{
    std::vector<CodePoint> codes;
    for (std::size_t at = 0; at < text.size();) {
        CodePoint code = 0;
        const utf8proc_ssize_t length =
            utf8proc_iterate(reinterpret_cast<const utf8proc_uint8_t*>(text.data() + at),
                             static_cast<utf8proc_ssize_t>(text.size() - at), &code);
        codes.push_back(length > 0 ? code : -1);
        at += to_size(std::max<utf8proc_ssize_t>(length, 1));
    }
    return codes;
}

/// "U+2013".
std::string print_code(CodePoint code)
{
    std::array<char, 8> digits{};
    const auto end = std::to_chars(digits.data(), digits.data() + digits.size(), code, 16);
    const std::string hexadecimal = upper_case({digits.data(), end.ptr});
    return "U+" + std::string(4 - std::min<std::size_t>(hexadecimal.size(), 4), '0') + hexadecimal;
}

/// "differ in ..." of values alike; empty where that can be seen.
std::string how_they_differ(const std::string& a, const std::string& b)
{
    if (without_case(a) == without_case(b) || (spelled_number(a) && spelled_number(b)))
        return {};
    const std::vector<CodePoint> of_a = code_points(a);
    const std::vector<CodePoint> of_b = code_points(b);
    const auto [in_a, in_b] = std::mismatch(
        of_a.begin(), of_a.end(), of_b.begin(), of_b.end(),
        [](CodePoint x, CodePoint y) { return utf8proc_tolower(x) == utf8proc_tolower(y); });
    std::vector<CodePoint> codes;
    if (in_a != of_a.end())
        codes.push_back(*in_a);
    if (in_b != of_b.end())
        codes.push_back(*in_b);
    for (const CodePoint code : codes)
        if (utf8proc_category(code) == UTF8PROC_CATEGORY_ZS ||
            utf8proc_category(code) == UTF8PROC_CATEGORY_CC)
            return "differ in blanks";
    for (const CodePoint code : codes)
        if (utf8proc_category(code) == UTF8PROC_CATEGORY_CF)
            return join("differ in a character that cannot be seen (", print_code(code), ")");
    return codes.size() < 2 ? "differ in characters that look alike"
                            : join("differ in characters that look alike (", print_code(codes[0]),
                                   " and ", print_code(codes[1]), ")");
}

/// Whether a number is written as codes of missing values are.
bool may_be_code(double number)
{
    std::string digits = print_number(std::abs(number));
    const bool is_whole = std::erase(digits, '.') == 0;
    const char digit = digits.front();
    if (digits.find_first_not_of(digit) != std::string::npos || (!is_whole && digits.size() < 3))
        return false;
    const bool is_seven_or_eight = digit == '7' || digit == '8';
    return digit == '9' || (is_seven_or_eight && (number < 0.0 || digits.size() >= 3));
}

std::string doubt_about_spelling(const LabelColumn& label)
{
    std::vector<std::string> alike = values_alike(label.values);
    if (alike.empty())
        return {};
    std::string how;
    for (std::size_t i = 1; i < alike.size() && how.empty(); ++i)
        how = how_they_differ(alike[0], alike[i]);
    for (std::string& value : alike)
        value = in_quotes(value);
    return join("label '", label.name, "' has the values ", list_names(alike), ", which ",
                how.empty() ? "are " : how + " and are ",
                alike.size() == 2 ? "two" : join(alike.size()),
                " groups; spell them alike if they mean one");
}

} // namespace

std::vector<std::string> values_alike(const std::vector<std::string>& values)
{
    std::map<std::string, std::vector<std::string>> spellings;
    std::vector<const std::vector<std::string>*> sets; // in the order of their first appearance
    for (const std::string& value : values) {
        if (value.empty())
            continue;
        const std::string look = look_of(value);
        const std::optional<double> number = spelled_number(look);
        const auto [set, is_new] = spellings.try_emplace(number ? print_number(*number) : look);
        if (is_new)
            sets.push_back(&set->second);
        if (std::find(set->second.begin(), set->second.end(), value) == set->second.end())
            set->second.push_back(value);
    }
    const auto found = std::find_if(sets.begin(), sets.end(),
                                    [](const auto* spelled) { return spelled->size() > 1; });
    return found == sets.end() ? std::vector<std::string>() : **found;
}

std::optional<MissingCodes> missing_codes(const std::vector<std::string>& values)
{
    std::map<double, std::vector<std::string>> codes;
    std::set<double> others;
    for (const std::string& value : values) {
        if (value.empty())
            continue;
        const std::optional<double> number = spelled_number(value);
        if (!number)
            return std::nullopt;
        if (may_be_code(*number))
            codes[*number].push_back(value);
        else
            others.insert(*number);
    }
    if (others.size() < 2)
        return std::nullopt;
    MissingCodes found{.codes = {}, .low = *others.begin(), .high = *others.rbegin()};
    const bool are_whole =
        std::ranges::all_of(others, [](double other) { return other == std::floor(other); });
    for (const auto& [code, spelled] : codes) {
        const double beyond = std::max(found.low - code, code - found.high);
        const bool is_alone_negative = code < 0.0 && found.low >= 0.0;
        const bool is_far = beyond >= found.high - found.low;
        if (!(is_alone_negative || is_far) || (code == 9.0 && !are_whole))
            continue;
        found.codes.push_back(spelled.front());
        found.count += spelled.size();
    }
    return found.codes.empty() ? std::nullopt : std::optional(found);
}

std::optional<std::string> doubt_about_numbers(const LabelColumn& label)
{
    const std::optional<MissingCodes> found = missing_codes(label.values);
    if (!found)
        return std::nullopt;
    std::vector<std::size_t> all(found->codes.size());
    std::iota(all.begin(), all.end(), 0);
    return join("label '", label.name, "' is ", list_names(found->codes, all), " in ",
                counted(found->count, "mesh", "meshes"), ", apart from all other numbers (",
                found->low, " to ", found->high,
                "); where that stands for a missing value, leave the cell empty");
}

std::optional<std::string> doubt_about_words(const LabelColumn& label)
{
    const std::vector<std::string> words = missing_words(label.values);
    if (words.empty())
        return std::nullopt;
    std::vector<std::string> quoted;
    for (const std::string& word : words)
        quoted.push_back(in_quotes(word));
    std::vector<std::size_t> all(words.size());
    std::iota(all.begin(), all.end(), 0);
    const auto count = std::ranges::count_if(label.values, [&](const std::string& value) {
        return std::ranges::find(words, value) != words.end();
    });
    return join("label '", label.name, "' is ", list_names(quoted, all), " in ",
                counted(count, "mesh", "meshes"), ", which counts as ",
                words.size() == 1 ? "a group" : "groups",
                "; where that stands for a missing value, leave the cell empty");
}

std::vector<std::string> missing_words(const std::vector<std::string>& values)
{
    // What people write where they have no value and read.csv does not know; none of it names a group elsewhere. "none" and
    // "other" do.
    static const std::set<std::string> known = {"unknown",
                                                "unk",
                                                "missing",
                                                "not available",
                                                "not known",
                                                "not recorded",
                                                "not applicable",
                                                "no data",
                                                "unbekannt",
                                                "inconnu",
                                                "desconocido",
                                                "sconosciuto",
                                                "nil",
                                                "n.a.",
                                                "n.a",
                                                "n/d",
                                                "nd",
                                                "n.d.",
                                                "n.d",
                                                "k.a.",
                                                "k. a.",
                                                "s/d",
                                                "(blank)",
                                                "blank",
                                                "undefined",
                                                "tbd",
                                                "tba"};
    std::set<std::string> looks;
    std::vector<std::string> words;
    std::vector<std::string> signs; // without a letter or a digit
    for (const std::string& value : values) {
        if (value.empty() || !looks.insert(value).second)
            continue;
        const std::string look = look_of(value);
        const std::vector<CodePoint> codes = code_points(look);
        const bool is_sign = std::ranges::none_of(codes, [](CodePoint code) {
            const utf8proc_category_t category = utf8proc_category(code);
            return category >= UTF8PROC_CATEGORY_LU && category <= UTF8PROC_CATEGORY_NO;
        });
        if (is_sign)
            signs.push_back(value);
        else if (known.contains(look) || label_value(look).empty())
            words.push_back(value);
    }
    if (!std::ranges::count(signs, "+")) // beside which - is a group
        words.insert(words.end(), signs.begin(), signs.end());
    return words.size() < looks.size() ? words : std::vector<std::string>();
}

std::vector<std::string> doubts_about(const Labels& labels)
{
    std::vector<std::string> sentences;
    for (const LabelColumn& label : labels) {
        if (std::string doubt = doubt_about_spelling(label); !doubt.empty())
            sentences.push_back(std::move(doubt));
        if (std::optional<std::string> doubt = doubt_about_numbers(label))
            sentences.push_back(std::move(*doubt));
        if (std::optional<std::string> doubt = doubt_about_words(label))
            sentences.push_back(std::move(*doubt));
    }
    return sentences;
}

} // namespace shape::internal
