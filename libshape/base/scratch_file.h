// SPDX-License-Identifier: MIT

#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>

namespace shape::internal {

/// A file for numbers that memory need not hold. It has no name, so that it goes with the process, however
/// that ends. Several threads may read and write at once.
class ScratchFile
{
public:
    /// Takes the room at once, so that writing finds it; none where the folder cannot be written to,
    /// its disk has less than twice as much free, or the system can promise none.
    [[nodiscard]] static std::optional<ScratchFile> make(const std::filesystem::path& folder,
                                                         std::uint64_t bytes);

    ScratchFile(ScratchFile&& other) noexcept;
    ScratchFile& operator=(ScratchFile&& other) noexcept;
    ScratchFile(const ScratchFile&) = delete;
    ScratchFile& operator=(const ScratchFile&) = delete;
    ~ScratchFile();

    /// @param first  Number of the first number, from the beginning of the file.
    /// @throws FileError if the system fails.
    void write(std::uint64_t first, std::span<const double> numbers) const;
    void read(std::uint64_t first, std::span<double> numbers) const;

private:
    explicit ScratchFile(int descriptor) : descriptor_(descriptor) {}

    int descriptor_;
};

} // namespace shape::internal
