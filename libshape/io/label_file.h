// SPDX-License-Identifier: MIT

#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "libshape/mesh/labels.h"

namespace shape {

/// Labels of the meshes of a collection, from a table that may be of a larger study.
struct LabelFile
{
    Labels labels;                   ///< Values as label_value() gives them.
    std::vector<std::string> unused; ///< Meshes of the table that were not asked for, in its order.
};

/// Two values of a label that differ in case, or in how a number is written, alone (`F` and `f`, `1` and
/// `1.0`), and so are seldom meant to be two: the first such pair, or nothing.
[[nodiscard]] std::optional<std::pair<std::string, std::string>> values_alike(
    const std::vector<std::string>& values);

/// A sentence of every label that has values_alike().
[[nodiscard]] std::vector<std::string> alike_values(const Labels& labels);

/// Two names that read_label_file() takes for one, unless a row spells one of them exactly: the first such pair, or
/// nothing. Equal names are none.
[[nodiscard]] std::optional<std::pair<std::size_t, std::size_t>> names_alike(
    const std::vector<std::string>& names);

/// Reads the labels of the named meshes from a table whose first column is `mesh`.
///
/// A row is of the mesh whose name it has; if there is none, of the one whose name is the same without
/// outer blanks, without the ending of a mesh file (.ply, .stl, ...) and with accents composed (Unicode
/// NFC) on both sides.
/// @throws InvalidInput as read_table(); if the first column has another name, a mesh has no row or
///     two, or a row could be of several meshes. Rows without anything in their cells are passed over.
[[nodiscard]] LabelFile read_label_file(const std::filesystem::path& path,
                                        const std::vector<std::string>& names);

/// The value that a cell gives: without outer blanks, accents composed (Unicode NFC); empty if it is
/// missing. Missing are the words that stand for no value in what R, Python and spreadsheets write, in
/// any case: NA, N/A, #N/A, #N/A N/A, #NA, <NA>, NaN, -NaN, 1.#QNAN, -1.#QNAN, 1.#IND, -1.#IND, NaT, NULL and `.`;
/// and the errors of spreadsheets #NULL!, #DIV/0!, #VALUE!, #REF!, #NAME?, #NUM!, #NV
[[nodiscard]] std::string label_value(std::string_view cell);

} // namespace shape
