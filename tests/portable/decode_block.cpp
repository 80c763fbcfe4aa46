// SPDX-License-Identifier: MIT

// decode_block BLOCK preview|fine SIZE SCORE... > positions, doubles as they lie. Links the portable core
// and nothing else of the library.

#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <iterator>

#include "libshape/explore/model_decoder.h"

#include "libshape/base/to_size.h"

int main(int argc, char** argv)
{
    using namespace shape::internal;
    if (argc < 4)
        return 2;
    std::ifstream file(argv[1], std::ios::binary);
    const std::vector<unsigned char> bytes{std::istreambuf_iterator<char>(file), {}};
    try {
        const ModelDecoder decoder(read_block(bytes));
        Eigen::VectorXd scores(argc - 4);
        for (int k = 0; k < scores.size(); ++k)
            scores[k] = std::strtod(argv[4 + k], nullptr);
        const DecodedModelPoint decoded = decoder.decode(
            scores, {}, std::strtod(argv[3], nullptr),
            std::strcmp(argv[2], "fine") == 0 ? DihedralEmbeddingOptions() : dihedral_preview());
        const shape::Points& points = decoded.embedding.points;
        std::fwrite(points.data(), sizeof(double), to_size(points.size()), stdout);
        return 0;
    } catch (const std::exception& error) {
        std::fprintf(stderr, "%s\n", error.what());
        return 1;
    }
}
