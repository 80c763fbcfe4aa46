// SPDX-License-Identifier: MIT

#pragma once

namespace shape {

/// Where the rotations of patches start from when neighbours are registered.
enum class RegistrationStart
{
    Incremental, ///< Each patch in turn gets the best fit to those before it.
    Identity,    ///< As printed (Winkler 2010, section 3.1).
};

struct RegistrationOptions
{
    /// Rotations start from this.
    RegistrationStart start = RegistrationStart::Incremental;
    /// Every patch is turned to its best fit this many times; >= 0.
    int passes = 4;
};

/// @throws InvalidInput naming the first field that breaks its rule.
void check(const RegistrationOptions& options);

} // namespace shape
