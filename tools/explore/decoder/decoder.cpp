// SPDX-License-Identifier: MIT

// The decoder as WebAssembly sees it: functions of numbers and addresses, one decoder a module.

#include <cstdint>
#include <cstdlib>
#include <memory>
#include <new>
#include <span>
#include <string>
#include <vector>

#include "libshape/base/error.h"
#include "libshape/explore/model_decoder.h"

using namespace shape::internal;

// emscripten's malloc() aligns to 8 bytes, and Eigen adds in another order where an array does not begin at 16: the
// same scores would not have the same bits every time.
void* operator new(std::size_t size)
{
    constexpr std::size_t alignment = 16;
    if (void* const memory = std::aligned_alloc(alignment, (size / alignment + 1) * alignment))
        return memory;
    throw std::bad_alloc();
}
void operator delete(void* memory) noexcept
{
    std::free(memory);
}
void operator delete(void* memory, std::size_t) noexcept
{
    std::free(memory);
}

namespace {

std::unique_ptr<ModelDecoder> decoder;
DecodedModelPoint shown;
std::vector<double> positions; // x y z of one vertex after the other
std::vector<double> figures;
std::string message;

/// Runs work and keeps what it throws as the message.
template <class Work>
int guarded(const Work& work)
{
    message.clear();
    try {
        work();
        return 1;
    } catch (const std::exception& error) {
        message = error.what();
        return 0;
    }
}

} // namespace

extern "C" {

/// Takes a block of write_block(), whose memory stays the caller's.
/// @return 1, or 0: then last_message() says why. So do all below that return int.
int open_model(const unsigned char* block, std::size_t size)
{
    return guarded([&] {
        decoder.reset();
        decoder = std::make_unique<ModelDecoder>(read_block({block, size}));
    });
}

/// @param quality  0: draft, 1: preview, 2: fine, of which alone faces that cross are counted.
int decode(const double* scores, int score_count, const double* amounts, int amount_count,
           double size, int quality)
{
    return guarded([&] {
        using Map = Eigen::Map<const Eigen::VectorXd>;
        const Map coordinates(scores, score_count);
        const Map added(amounts, amount_count);
        shown = quality == 0   ? decoder->draft(coordinates, added, size)
                : quality == 1 ? decoder->decode(coordinates, added, size, dihedral_preview())
                               : decoder->decode(coordinates, added, size, {});
        const CrossingCount::Count crossings = quality == 2
                                                   ? decoder->crossings(shown.embedding.points)
                                                   : CrossingCount::Count{-1, -1};
        const shape::EmbeddingReport& report = shown.embedding.report;
        figures = {static_cast<double>(report.status),
                   report.edge_rms,
                   report.edge_max,
                   report.edge_p999,
                   report.edge_p99,
                   report.dihedral_rms_deg,
                   report.dihedral_p99_deg,
                   report.dihedral_max_deg,
                   report.closure_energy,
                   static_cast<double>(report.inverted_faces),
                   static_cast<double>(report.iterations),
                   report.converged ? 1.0 : 0.0,
                   static_cast<double>(crossings.all),
                   static_cast<double>(crossings.in_no_reference)};
        message = report.reason;
    });
}

/// By how much the scores and amounts are to be multiplied so that no triangle inequality breaks:
/// 1, or less; 0 if it takes more than a hundredfold. -1: last_message() says why.
double feasible_share(const double* scores, int score_count, const double* amounts,
                      int amount_count, double size)
{
    using Map = Eigen::Map<const Eigen::VectorXd>;
    double share = 1.0;
    const int done = guarded([&] {
        while (share > 0.0 && !decoder->is_feasible(share * Map(scores, score_count),
                                                    share * Map(amounts, amount_count), size))
            share = share > 0.01 ? 0.9 * share : 0.0;
    });
    return done != 0 ? share : -1.0;
}

int vertex_count()
{
    return decoder->block().topology.vertex_count();
}
int face_count()
{
    return decoder->block().topology.face_count();
}
const int* faces()
{
    return decoder->block().topology.faces().data();
}

// Of the last decode():
const double* shown_positions() ///< #V by 3 [length].
{
    return shown.embedding.points.data();
}
const float* shown_edge_error() ///< #V.
{
    return shown.edge_error.data();
}
const float* shown_dihedral_drift() ///< #V [deg].
{
    return shown.dihedral_drift.data();
}
const char* shown_broken_faces() ///< #F.
{
    return shown.broken_faces.data();
}
const double* shown_figures() ///< In the order of decode() above.
{
    return figures.data();
}
int shown_figure_count()
{
    return static_cast<int>(figures.size());
}
const char* last_message() ///< What failed; else why the target is infeasible, or empty.
{
    return message.c_str();
}
}
