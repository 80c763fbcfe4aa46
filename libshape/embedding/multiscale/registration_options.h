// SPDX-License-Identifier: MIT

#pragma once

namespace shape {

/// Where the rotations of patches start from (patch_registration.h).
enum class RegistrationStart
{
    Incremental, ///< Each patch in turn gets the best fit to those before it.
    Identity,    ///< As printed (Winkler 2010, section 3.1).
};

struct RegistrationOptions
{
    RegistrationStart start = RegistrationStart::Incremental;
    int passes = 4; ///< Over all patches; >= 0.
};

} // namespace shape
