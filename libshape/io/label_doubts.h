// SPDX-License-Identifier: MIT

#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "libshape/mesh/labels.h"

namespace shape::internal {

/// Values of a label that are told apart and seldom meant to be: the first such set in the order of their first
/// appearance, or nothing. They differ alone
/// - in case, or in how a number is written (`F` and `f`, `1` and `1.0`);
/// - in blanks, their number or kind;
/// - in the quotes, and the = before them, by which spreadsheets mark text;
/// - in characters that look alike: dashes, quotes, wide letters and ligatures, letters of Latin, Greek and Cyrillic
///   whose capitals have one form; or in such as cannot be seen.
[[nodiscard]] std::vector<std::string> values_alike(const std::vector<std::string>& values);

/// Numbers of a label that are likely to stand for no value.
struct MissingCodes
{
    std::vector<std::string> codes; ///< As they are written, ascending.
    std::size_t count = 0;          ///< So many values are one of them.
    double low = 0.0;               ///< The least and
    double high = 0.0;              ///< the largest of all others.
};

/// Codes as surveys and instruments write them: numbers of nines (9, 99, 99.9, 999, -9, ...), of three and more sevens or
/// eights, or negative ones of these digits, that are beyond all others by at least as much as these span, or are
/// negative where no other is. A 9 is none beside numbers that are not whole. There must be two different others.
/// @return Nothing, too, if some value is no number.
[[nodiscard]] std::optional<MissingCodes> missing_codes(const std::vector<std::string>& values);

/// A sentence for missing_codes().
[[nodiscard]] std::optional<std::string> doubt_about_numbers(const LabelColumn& label);

/// Words and signs of a label that are likely to stand for no value, though they are none of label_value(): unknown, n.d.,
/// (blank), -, ?, NA in quotes and the like, in the order of their first appearance. No signs where one of them is +.
/// @return Nothing, too, if there is no other value.
[[nodiscard]] std::vector<std::string> missing_words(const std::vector<std::string>& values);

/// A sentence for missing_words().
[[nodiscard]] std::optional<std::string> doubt_about_words(const LabelColumn& label);

/// Those for each label that has them, and one for each that has values_alike().
[[nodiscard]] std::vector<std::string> doubts_about(const Labels& labels);

} // namespace shape::internal
