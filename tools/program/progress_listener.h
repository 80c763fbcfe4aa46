// SPDX-License-Identifier: MIT

#pragma once

#include "libshape/base/progress.h"

namespace shape::tools {

/// While it lives, commands that this thread carries out tell their progress to a function, in place of the
/// terminal (Session::progress()): for hosts of the commands other than the program.
class ProgressListener
{
public:
    explicit ProgressListener(Progress told);
    ProgressListener(const ProgressListener&) = delete;
    ProgressListener& operator=(const ProgressListener&) = delete;
    ~ProgressListener();
};

} // namespace shape::tools
