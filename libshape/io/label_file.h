// SPDX-License-Identifier: MIT

#pragma once

#include <cstddef>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "libshape/io/table_file.h"
#include "libshape/mesh/labels.h"

namespace shape {

/// Labels of the meshes of a collection, from a table that may be of a larger study.
struct LabelFile
{
    Labels labels;                   ///< Values as label_value() gives them.
    std::vector<std::string> unused; ///< Meshes of the table that were not asked for, in its order.
    std::vector<std::size_t> nameless; ///< Columns called by blanks alone, from 0: left out.
};

/// Two names that read_label_file() takes for one, unless a row spells one of them exactly: the first such pair, or
/// nothing. Equal names are none.
[[nodiscard]] std::optional<std::pair<std::size_t, std::size_t>> names_alike(
    const std::vector<std::string>& names);

/// The name of a label that a column of a table gives: without outer blanks, accents composed (Unicode NFC).
[[nodiscard]] std::string label_name(std::string_view column);

/// Whether files of collections and models can hold a label of this name: it is not empty and has no NUL in it.
[[nodiscard]] bool is_storable_label(std::string_view name);

/// A table as read_table() gives it, by the rules of labels: columns are called as label_name() says, and rows without
/// anything in their cells are left out.
/// @throws as read_table(); InvalidInput if two columns have one name then, which is not empty.
[[nodiscard]] Table read_label_table(const std::filesystem::path& path);

/// Reads the labels of the named meshes from a table whose first column is `mesh`.
///
/// A row is of the mesh whose name it has; if there is none, of the one whose name is the same without
/// outer blanks, without the ending of a mesh file (.ply, .stl, ...) and with accents composed (Unicode
/// NFC) on both sides.
/// @throws as read_label_table(); InvalidInput if the first column has another name, a mesh has no row or two, or a row
///     could be of several meshes.
[[nodiscard]] LabelFile read_label_file(const std::filesystem::path& path,
                                        const std::vector<std::string>& names);

/// The value that a cell gives: without outer blanks, accents composed (Unicode NFC); empty if it is
/// missing. Missing are the words that stand for no value in what R, Python and spreadsheets write, in
/// any case: NA, N/A, #N/A, #N/A N/A, #NA, <NA>, NaN, -NaN, NaN(ind), -NaN(ind), 1.#QNAN, -1.#QNAN, 1.#IND, -1.#IND,
/// NaT, NULL and `.`;
/// and the errors of spreadsheets #NULL!, #DIV/0!, #VALUE!, #REF!, #NAME?, #NUM!, #NV
[[nodiscard]] std::string label_value(std::string_view cell);

} // namespace shape
