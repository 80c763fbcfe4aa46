#include "libshape/mesh/loud.h"
namespace shape {
}
