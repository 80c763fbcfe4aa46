// SPDX-License-Identifier: MIT

#pragma once

#include <cstdint>
#include <memory>

#include "libshape/edge_space/shape_vectors.h"
#include "libshape/embedding/multiscale/registration_options.h"
#include "libshape/mesh/points.h"
#include "libshape/mesh/topology.h"

namespace shape {

struct MultiscaleOptions
{
    /// The seed triangles of the patches are drawn by this.
    std::uint64_t seed = 1;
    /// A patch is split into this many, m of the paper; in [4, 16].
    int children = 6;
    /// Neighbouring patches are registered as these options say.
    RegistrationOptions registration{};
};

/// @throws InvalidInput naming the first field that breaks its rule.
void check(const MultiscaleOptions& options);

/// Wall times [s] of what is done once per topology (Winkler 2010, Table 1).
struct MultiscaleSetupTimes
{
    double splitting = 0.0;
    double factorising = 0.0;
};

/// Times [s] of one pose (Winkler 2010, Table 1). The parts are summed over all threads.
struct MultiscalePoseTimes
{
    double interpolation = 0.0; ///< Gluing the leaves.
    double registration = 0.0;
    double blending = 0.0;
    double total = 0.0; ///< Wall time.
};

struct MultiscaleEmbedding
{
    Points points; ///< #V by 3 [length], centroid at 0.
    MultiscalePoseTimes times;
};

/// Multi-scale embedding (Winkler, Drieseberg, Alexa, Hormann 2010, section 3): small patches are
/// glued from edge lengths and dihedral angles, then ever larger ones registered and blended.
///
/// Blending is least squares of edge vectors that keep their directions and get their wanted
/// lengths (condition (3) of the paper). The hierarchy and the factorised normal matrices are kept.
class MultiscaleEmbedder
{
public:
    /// @param reference  Any mesh of the topology. Its orientation is that of the glued leaves and
    ///     so, roughly, of the results.
    /// @throws InvalidInput if reference has another size or an option is out of its range.
    MultiscaleEmbedder(const Topology& topology, const Points& reference,
                       const MultiscaleOptions& options = {});
    ~MultiscaleEmbedder();
    MultiscaleEmbedder(MultiscaleEmbedder&&) noexcept;
    MultiscaleEmbedder& operator=(MultiscaleEmbedder&&) noexcept;

    /// A mesh's own lengths and angles give that mesh up to a rigid motion and rounding.
    /// @throws InvalidInput if target has other sizes, a value that is not finite or an angle beyond 1e9 rad.
    /// @throws NumericalError if target breaks a triangle inequality; the message names the face.
    /// Cost: about #V log #V, of which one back-substitution for the whole mesh is serial.
    /// Same bits for any thread count. Safe to call concurrently.
    [[nodiscard]] MultiscaleEmbedding embed(const ShapePoint& target) const;

    [[nodiscard]] const MultiscaleSetupTimes& setup_times() const;

private:
    struct State;
    std::unique_ptr<State> state_;
};

} // namespace shape
