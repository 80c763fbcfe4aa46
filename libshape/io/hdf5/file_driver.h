// SPDX-License-Identifier: MIT

#pragma once

#include "libshape/io/hdf5/handles.h"

namespace shape::internal {

/// Where HDF5 writes a new file: through us, for it does not report every error of a disk. No error
/// meets it; the first one is kept here, and what is written after it is lost.
struct NewFile
{
    int descriptor = -1; ///< Open for reading and writing, empty; stays open.
    int error = 0;       ///< errno of the first call that failed; 0 if none did.
};

/// Lets files that are created with this access list live in `file`, which must outlive them.
void write_through(hid_t access, NewFile& file);

} // namespace shape::internal
