// SPDX-License-Identifier: MIT

#pragma once

// What most sources of the decoder include, parsed once: two fifths of the time of their compilation.

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <Eigen/SparseCore>
#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <memory>
#include <optional>
#include <sstream>
#include <string>
#include <utility>
#include <vector>
