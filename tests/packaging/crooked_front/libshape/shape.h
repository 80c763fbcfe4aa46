#include "libshape/mesh/forgotten_by_all.h"
#include "libshape/mesh/shy.h"
