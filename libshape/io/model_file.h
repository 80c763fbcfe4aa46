// SPDX-License-Identifier: MIT

#pragma once

#include <filesystem>
#include <optional>
#include <string>

#include "libshape/base/error.h"
#include "libshape/model/difference.h"
#include "libshape/model/shape_model.h"

namespace shape {

/// What an HDF5 file of libshape holds.
enum class FileKind
{
    Collection,
    Model,
    Difference,
};

/// An HDF5 file of another kind than the one to be read, or not of libshape at all.
class WrongFileKind : public InvalidInput
{
public:
    WrongFileKind(const std::string& message, std::optional<FileKind> kind)
        : InvalidInput(message), wanted(kind)
    {
    }

    std::optional<FileKind> wanted; ///< None where all kinds are read.
};

/// @throws as read_collection(); WrongFileKind if the file is not written by libshape.
[[nodiscard]] FileKind file_kind(const std::filesystem::path& path);

/// Writes and checks a model as write_collection() does a collection; likewise a difference, below.
/// @param asked  What the model was fitted, or the difference taken with; kept as attributes.
/// @throws InvalidInput if a value is one that the readers refuse; FileError if it cannot be written.
void write_model(const std::filesystem::path& path, const ShapeModel& model,
                 const std::optional<ModelOptions>& asked = {});
void write_difference(const std::filesystem::path& path, const DifferenceVector& difference,
                      const std::optional<DifferenceOptions>& asked = {}); ///< As write_model().

/// Reads a model or, below, a difference, checking every value. @throws as read_collection().
[[nodiscard]] ShapeModel read_model(const std::filesystem::path& path);
[[nodiscard]] DifferenceVector read_difference(const std::filesystem::path& path); ///< Likewise.

} // namespace shape
