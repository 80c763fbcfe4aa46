// SPDX-License-Identifier: MIT

#include "tools/input/natural_order.h"

#include <algorithm>
#include <compare>
#include <utility>

namespace shape::tools {
namespace {

bool is_digit(char c)
{
    return c >= '0' && c <= '9';
}

bool is_word_character(char c)
{
    return is_digit(c) || (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c & 0x80) != 0;
}

std::size_t end_of_digits(std::string_view text, std::size_t at)
{
    while (at < text.size() && is_digit(text[at]))
        ++at;
    return at;
}

/// A piece of a name: a number, or one other character.
struct Piece
{
    std::string_view text = {};
    bool is_number = false;
    bool is_negative = false;
    std::string_view whole = {};    ///< Digits before the point, without leading zeros.
    std::string_view fraction = {}; ///< Digits behind it, without zeros at the end.
};

Piece piece_at(std::string_view text, std::size_t begin)
{
    const bool may_be_signed = begin == 0 || !is_word_character(text[begin - 1]);
    const bool is_signed = may_be_signed && (text[begin] == '-' || text[begin] == '+') &&
                           begin + 1 < text.size() && is_digit(text[begin + 1]);
    const std::size_t first = begin + (is_signed ? 1 : 0);
    if (!is_digit(text[first]))
        return {.text = text.substr(begin, 1)};
    std::size_t end = end_of_digits(text, first);
    Piece piece{.is_number = true, .whole = text.substr(first, end - first)};
    if (end + 1 < text.size() && text[end] == '.' && is_digit(text[end + 1])) {
        const std::size_t point = end;
        end = end_of_digits(text, point + 1);
        piece.fraction = text.substr(point + 1, end - point - 1);
        piece.fraction = piece.fraction.substr(0, piece.fraction.find_last_not_of('0') + 1);
    }
    piece.whole.remove_prefix(std::min(piece.whole.find_first_not_of('0'), piece.whole.size()));
    const bool is_zero = piece.whole.empty() && piece.fraction.empty();
    piece.is_negative = text[begin] == '-' && !is_zero;
    piece.text = text.substr(begin, end - begin);
    return piece;
}

std::strong_ordering magnitude_order(const Piece& a, const Piece& b)
{
    if (const auto order = a.whole.size() <=> b.whole.size(); std::is_neq(order))
        return order;
    if (const auto order = a.whole <=> b.whole; std::is_neq(order))
        return order;
    return a.fraction <=> b.fraction;
}

/// Numbers stand where their digits would among the other characters.
std::strong_ordering order_of(const Piece& a, const Piece& b)
{
    if (a.is_number != b.is_number)
        return (a.is_number ? '0' : static_cast<unsigned char>(a.text[0])) <=>
               (b.is_number ? '0' : static_cast<unsigned char>(b.text[0]));
    if (!a.is_number)
        return static_cast<unsigned char>(a.text[0]) <=> static_cast<unsigned char>(b.text[0]);
    if (a.is_negative != b.is_negative)
        return a.is_negative ? std::strong_ordering::less : std::strong_ordering::greater;
    return a.is_negative ? magnitude_order(b, a) : magnitude_order(a, b);
}

} // namespace

bool natural_less(std::string_view a, std::string_view b)
{
    std::size_t i = 0;
    std::size_t j = 0;
    while (i < a.size() && j < b.size()) {
        const Piece p = piece_at(a, i);
        const Piece q = piece_at(b, j);
        if (const auto order = order_of(p, q); std::is_neq(order))
            return std::is_lt(order);
        i += p.text.size();
        j += q.text.size();
    }
    return std::pair(a.size() - i, a) < std::pair(b.size() - j, b);
}

} // namespace shape::tools
