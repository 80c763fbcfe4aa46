// SPDX-License-Identifier: MIT

#include "tools/input/natural_order.h"

#include <algorithm>
#include <array>
#include <compare>
#include <numeric>
#include <set>
#include <string_view>
#include <tuple>
#include <utility>

#include "libshape/base/letter_case.h"

namespace shape::tools {
namespace {

constexpr std::string_view hyphen = "-";
constexpr std::string_view minus = "\xE2\x88\x92"; // of Unicode, which is nothing but a sign

bool is_digit(char c)
{
    return c >= '0' && c <= '9';
}

bool is_letter(char c)
{
    return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c & 0x80) != 0;
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
    std::string_view text = {}; ///< Without a sign.
    bool is_number = false;
    bool is_negative = false;
    std::string_view whole = {};    ///< Digits before the point, without leading zeros.
    std::string_view fraction = {}; ///< Digits behind it, without zeros at the end.
};

/// Whether a point and a digit stand there.
bool is_point_at(std::string_view text, std::size_t at)
{
    return at + 1 < text.size() && text[at] == '.' && is_digit(text[at + 1]);
}

/// Whether a number begins there that has two points or more: no decimal, but a version or a date.
bool is_version_at(std::string_view text, std::size_t begin)
{
    const std::size_t end = end_of_digits(text, begin);
    return is_point_at(text, end) && is_point_at(text, end_of_digits(text, end + 1));
}

/// @param is_decimal  Whether a number may have digits behind a point.
Piece piece_at(std::string_view text, std::size_t begin, bool is_decimal)
{
    if (!is_digit(text[begin]))
        return {.text = text.substr(begin, 1)};
    std::size_t end = end_of_digits(text, begin);
    Piece piece{.is_number = true, .whole = text.substr(begin, end - begin)};
    if (is_decimal && is_point_at(text, end)) {
        const std::size_t point = end;
        end = end_of_digits(text, point + 1);
        piece.fraction = text.substr(point + 1, end - point - 1);
        piece.fraction = piece.fraction.substr(0, piece.fraction.find_last_not_of('0') + 1);
    }
    piece.whole.remove_prefix(std::min(piece.whole.find_first_not_of('0'), piece.whole.size()));
    piece.text = text.substr(begin, end - begin);
    return piece;
}

/// A piece, and what may be its sign.
struct SignedPiece
{
    Piece piece;
    std::string_view sign = {}; ///< Right before a number.
    bool may_separate = false;  ///< It is a hyphen behind a letter or another hyphen.
    std::string place = {};     ///< Of a number: what stands before its sign, numbers as `#`.
    bool is_version = false; ///< It is the first of a version: of two points, or behind the word.
    bool is_decimal =
        false; ///< It is none: it has a sign that is nothing else, or a fraction such as 05.
};

/// Of numbers.
using NumberPlaces = std::set<std::string>;

/// What stands at `at` if it can be the sign of the number behind it.
std::string_view sign_at(std::string_view text, std::size_t at)
{
    if (at > 0 && is_digit(text[at - 1]))
        return {};
    for (const std::string_view sign : {hyphen, std::string_view("+"), minus}) {
        const std::size_t next = at + sign.size();
        if (text.substr(at).starts_with(sign) && next < text.size() && is_digit(text[next]))
            return text.substr(at, sign.size());
    }
    return {};
}

/// Whether what stands before a number says that it is a version.
bool is_version_word(std::string_view before)
{
    while (before.ends_with(' ') || before.ends_with('_') || before.ends_with('-'))
        before.remove_suffix(1);
    std::size_t begin = before.size();
    while (begin > 0 && is_letter(before[begin - 1]))
        --begin;
    const std::string word = internal::lower_case(std::string(before.substr(begin)));
    return word == "v" || word == "ver" || word == "version" || word == "rev" || word == "revision";
}

/// Whether a number begins there that no version is spelled as: its fraction begins with a zero, and goes on.
bool is_sure_decimal_at(std::string_view text, std::size_t begin)
{
    const std::size_t point = end_of_digits(text, begin);
    return is_point_at(text, point) && !is_version_at(text, begin) && text[point + 1] == '0' &&
           end_of_digits(text, point + 1) > point + 2 &&
           text.substr(point + 1, end_of_digits(text, point + 1) - point - 1)
                   .find_first_not_of('0') != std::string_view::npos;
}

/// @param versions  Where points are none of decimals in any name.
std::vector<SignedPiece> signed_pieces(std::string_view text, const NumberPlaces& versions)
{
    std::vector<SignedPiece> pieces;
    std::string place;
    for (std::size_t at = 0; at < text.size();) {
        SignedPiece next{.piece = {}, .sign = sign_at(text, at)};
        next.may_separate =
            next.sign == hyphen && at > 0 && (is_letter(text[at - 1]) || text[at - 1] == '-');
        at += next.sign.size();
        if (is_digit(text[at])) {
            next.place = place;
            next.is_version = is_version_at(text, at) || is_version_word(text.substr(0, at));
            next.is_decimal =
                (!next.sign.empty() && !next.may_separate) || is_sure_decimal_at(text, at);
        }
        const bool goes_on = at > 1 && text[at - 1] == '.' && is_digit(text[at - 2]);
        next.piece =
            piece_at(text, at, !is_version_at(text, at) && !goes_on && !versions.contains(place));
        at += next.piece.text.size();
        place += next.piece.is_number ? "#" : next.piece.text;
        pieces.push_back(std::move(next));
    }
    return pieces;
}

/// Those at which numbers stand without a hyphen: one that stands there elsewhere is a sign.
void add_places(const std::vector<SignedPiece>& pieces, NumberPlaces& places)
{
    for (const SignedPiece& next : pieces)
        if (next.piece.is_number && (next.sign.empty() || next.sign == "+"))
            places.insert(next.place);
        else if (next.may_separate)
            places.insert(next.place + '-');
}

/// The pieces once it is known which signs there are.
std::vector<Piece> decided(const std::vector<SignedPiece>& pieces, const NumberPlaces& places)
{
    std::vector<Piece> result;
    for (const SignedPiece& next : pieces) {
        Piece piece = next.piece;
        const bool is_sign = !next.may_separate || places.contains(next.place);
        if (!is_sign)
            result.push_back({.text = next.sign});
        const bool is_zero = piece.whole.empty() && piece.fraction.empty();
        piece.is_negative = is_sign && !is_zero && (next.sign == hyphen || next.sign == minus);
        result.push_back(piece);
    }
    return result;
}

std::strong_ordering magnitude_order(const Piece& a, const Piece& b)
{
    return std::tuple(a.whole.size(), a.whole, a.fraction) <=>
           std::tuple(b.whole.size(), b.whole, b.fraction);
}

/// Numbers stand where their digits would among the other characters.
std::strong_ordering order_of(const Piece& a, const Piece& b)
{
    if (!a.is_number || !b.is_number)
        return (a.is_number ? '0' : static_cast<unsigned char>(a.text[0])) <=>
               (b.is_number ? '0' : static_cast<unsigned char>(b.text[0]));
    if (a.is_negative != b.is_negative)
        return a.is_negative ? std::strong_ordering::less : std::strong_ordering::greater;
    return a.is_negative ? magnitude_order(b, a) : magnitude_order(a, b);
}

std::strong_ordering order_of(const std::vector<Piece>& a, const std::vector<Piece>& b)
{
    return std::lexicographical_compare_three_way(
        a.begin(), a.end(), b.begin(), b.end(),
        [](const Piece& p, const Piece& q) { return order_of(p, q); });
}

/// Where the ending of a file's name begins: its last point, if a letter follows and no more than four letters and
/// digits after that; else the end.
std::size_t beginning_of_ending(std::string_view name)
{
    constexpr std::size_t longest = 5;
    const std::size_t point = name.rfind('.');
    if (point == std::string_view::npos || point == 0 || point + 1 == name.size() ||
        name.size() - point - 1 > longest || !is_letter(name[point + 1]))
        return name.size();
    const std::string_view ending = name.substr(point + 1);
    return std::all_of(ending.begin(), ending.end(),
                       [](char c) { return is_letter(c) || is_digit(c); })
               ? point
               : name.size();
}

} // namespace

void sort_naturally(std::vector<std::string>& names)
{
    struct Key
    {
        std::array<std::vector<Piece>, 2> parts; ///< The stem and the ending.
        std::string_view name;
    };
    std::vector<std::array<std::vector<SignedPiece>, 2>> split_names;
    NumberPlaces versions, decimals;
    for (const std::string_view name : names)
        for (const SignedPiece& piece :
             signed_pieces(name.substr(0, beginning_of_ending(name)), {})) {
            if (piece.is_version)
                versions.insert(piece.place);
            if (piece.is_decimal)
                decimals.insert(piece.place);
        }
    std::erase_if(versions, [&](const auto& place) { return decimals.contains(place); });
    NumberPlaces places;
    for (const std::string_view name : names) {
        const std::size_t end = beginning_of_ending(name);
        split_names.push_back({signed_pieces(name.substr(0, end), versions),
                               signed_pieces(name.substr(end), versions)});
        add_places(split_names.back()[0], places);
    }
    std::vector<Key> keys(names.size());
    for (std::size_t i = 0; i < names.size(); ++i)
        keys[i] = {{decided(split_names[i][0], places), decided(split_names[i][1], places)},
                   names[i]};
    std::sort(keys.begin(), keys.end(), [](const Key& a, const Key& b) {
        for (std::size_t part = 0; part < 2; ++part)
            if (const auto order = order_of(a.parts[part], b.parts[part]); std::is_neq(order))
                return std::is_lt(order);
        return a.name < b.name;
    });
    std::vector<std::string> sorted;
    for (const Key& key : keys)
        sorted.emplace_back(key.name);
    names = std::move(sorted);
}

} // namespace shape::tools
