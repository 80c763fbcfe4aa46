// SPDX-License-Identifier: MIT

#pragma once

#include <stdexcept>
#include <string>

namespace shape {

/// Base of everything the library throws on purpose. Not having converged, or a target that no
/// mesh can have, is never thrown: it is a field of the result.
class Error : public std::runtime_error
{
public:
    using std::runtime_error::runtime_error;
};

/// A broken precondition. The message names argument (or file), index, value and rule.
class InvalidInput : public Error
{
public:
    using Error::Error;
};

/// A computation broke down: a factorisation failed, a value is not finite.
class NumericalError : public Error
{
public:
    using Error::Error;
};

/// The operating system refused to read or write a file. The message names the path and the cause.
class FileError : public Error
{
public:
    using Error::Error;
};

/// The input is larger than a stated limit. The message names the limit.
class LimitExceeded : public Error
{
public:
    using Error::Error;
};

/// The caller asked for the work to stop (see progress.h).
class Interrupted : public Error
{
public:
    using Error::Error;
};

} // namespace shape
