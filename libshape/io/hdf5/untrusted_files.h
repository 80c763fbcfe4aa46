// SPDX-License-Identifier: MIT

#pragma once

namespace shape {

/// For programs that open HDF5 files of strangers. From now on a child process asks HDF5 what is in such a
/// file, and passes it on; it has limits of time and memory. The crash of HDF5 on a crafted file
/// (docs/reliability.md) is then an InvalidInput. Off until asked for: a library must not fork behind
/// its program's back.
///
/// The child has the calling thread alone. Where other threads may be inside HDF5 just then, the
/// child may wait for what they hold until its time is over, and a sound file be refused.
void isolate_hdf5_files(bool wanted);

} // namespace shape
