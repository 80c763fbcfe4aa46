// SPDX-License-Identifier: MIT

#pragma once

// All public headers of shape::pictures.

#include "libshape/report/colour_map.h"
#include "libshape/report/heat_map.h"
#include "libshape/report/image.h"
#include "libshape/report/page.h"
#include "libshape/report/picture.h"
#include "libshape/report/plot.h"
#include "libshape/report/render.h"
#include "libshape/report/score_plot.h"
#include "libshape/report/svg.h"
