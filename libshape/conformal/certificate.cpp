// SPDX-License-Identifier: MIT

#include "libshape/conformal/certificate.h"

namespace shape {

const char* name(ConformalCertificate certificate)
{
    switch (certificate) {
        case ConformalCertificate::Exact:
            return "exact";
        case ConformalCertificate::Folded:
            return "folded";
        case ConformalCertificate::Repaired:
            return "repaired";
        case ConformalCertificate::Refined:
            return "refined";
        case ConformalCertificate::Unsolved:
            break;
    }
    return "unsolved";
}

} // namespace shape
