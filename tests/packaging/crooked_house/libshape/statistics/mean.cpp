// SPDX-License-Identifier: MIT

#include <sys/stat.h>

#include <OpenMesh/Core/IO/MeshIO.hh>
#include "libshape/mesh/public.h"
#include "mean.h"
