// SPDX-License-Identifier: MIT

#include "libshape/embedding/start/patch_frames.h"

#include <Eigen/LU>
#include <Eigen/QR>
#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "libshape/base/error.h"
#include "libshape/base/format.h"
#include "libshape/base/random.h"
#include "libshape/base/threads.h"
#include "libshape/base/to_size.h"
#include "libshape/mesh/alignment.h"

namespace shape::internal {
namespace {

using Eigen::Matrix3d;
using Eigen::Quaterniond;
using Eigen::VectorXd;

/// Half-edges by the weight of their edges: the heaviest first, those of about the same weight first
/// in, first out, so that trees stay shallow.
class Front
{
public:
    explicit Front(int capacity) : next_(to_size(capacity)) {}

    void push(int halfedge, double weight)
    {
        const int level = level_of(weight);
        Queue& queue = queues_[to_size(level)];
        (queue.first < 0 ? queue.first : next_[to_size(queue.last)]) = halfedge;
        queue.last = halfedge;
        next_[to_size(halfedge)] = -1;
        highest_ = std::max(highest_, level);
    }

    /// -1 where none is left.
    int pop()
    {
        while (highest_ >= 0 && queues_[to_size(highest_)].first < 0)
            --highest_;
        if (highest_ < 0)
            return -1;
        int& first = queues_[to_size(highest_)].first;
        return std::exchange(first, next_[to_size(first)]);
    }

private:
    struct Queue
    {
        int first = -1, last = -1;
    };
    static constexpr int levels = 81; // eight an octave

    /// 8 log2(weight), rounded down.
    static int level_of(double weight)
    {
        static constexpr std::array eighth_powers{
            1.0905077326652577, 1.189207115002721, 1.2968395546510096, 1.4142135623730951,
            1.5422108254079407, 1.681792830507429, 1.8340080864093424, 2.0}; // of two
        int exponent = 0;
        const double mantissa = 2.0 * std::frexp(weight, &exponent);
        int eighths = static_cast<int>(8.0 * (mantissa - 1.0)); // that or one more
        if (mantissa >= eighth_powers[to_size(eighths)])
            ++eighths;
        return std::max(0, levels - 1 + 8 * (exponent - 1) + eighths);
    }

    std::array<Queue, levels> queues_;
    std::vector<int> next_;
    int highest_ = -1;
};

/// The pattern of the connection Laplacian, lower triangle, with the values of the identity. In every
/// column the diagonal stands first, then three rows for every pair of its patch.
SparseMatrix pattern(const FacePatches& patches)
{
    const int size = 3 * patches.count();
    SparseMatrix matrix(size, size);
    const Eigen::Index entries = size + 9 * static_cast<Eigen::Index>(patches.pairs.size());
    matrix.resizeNonZeros(entries);
    std::fill_n(matrix.valuePtr(), entries, 0.0);
    int entry = 0;
    auto pair = patches.pairs.begin();
    for (int column = 0; column < size; ++column) {
        matrix.outerIndexPtr()[column] = entry;
        matrix.valuePtr()[entry] = 1.0;
        matrix.innerIndexPtr()[entry++] = column;
        auto end = pair;
        for (; end != patches.pairs.end() && end->lower == column / 3; ++end)
            for (int i = 0; i < 3; ++i)
                matrix.innerIndexPtr()[entry++] = 3 * end->higher + i;
        if (column % 3 == 2)
            pair = end;
    }
    matrix.outerIndexPtr()[size] = entry;
    return matrix;
}

/// The three smallest eigenvectors, stacked 3 by 3 blocks, by inverse iterations from a fixed start.
Eigen::MatrixXd smallest_eigenvectors(const SparseCholesky& factor)
{
    // Where loops are far from closing the fourth eigenvalue is about as small: no number of steps would
    // tell them apart, and any of these vectors does.
    constexpr int max_iterations = 12;
    // Of the norm: half a degree in the frames, which local steps and descent turn further than that.
    // What is left is less, by the ratio of the last two changes.
    constexpr double settled = 1e-2;
    Random random(1);
    Eigen::MatrixXd vectors =
        Eigen::MatrixXd::NullaryExpr(factor.size(), 3, [&] { return random.uniform(-1.0, 1.0); });
    for (int i = 0; i < max_iterations; ++i) {
        const Eigen::HouseholderQR<Eigen::MatrixXd> qr(factor.solve(vectors));
        const Eigen::MatrixXd last =
            std::exchange(vectors, qr.householderQ() * Eigen::MatrixXd::Identity(factor.size(), 3));
        if ((vectors - last * (last.transpose() * vectors)).norm() < settled)
            break;
    }
    return vectors;
}

} // namespace

PatchFrames::PatchFrames(std::shared_ptr<const FacePatches> patches)
    : patches_(std::move(patches)),
      trust_(static_cast<Eigen::Index>(patches_->faces.size())),
      connection_(pattern(*patches_)),
      factor_(connection_, Ordering::MinimumDegree)
{
}

/// Prim's trees of the heaviest edges.
void PatchFrames::grow_trees(const Rotations& transitions, const VectorXd& weights,
                             Rotations& frames)
{
    const FacePatches& patches = *patches_;
    parallel_for(to_size(patches.count()), 16, [&](std::size_t begin, std::size_t end) {
        // Of the patch at hand, by place.
        Rotations frame(to_size(patches.largest));
        std::vector<double> trust(frame.size());
        Front front(3 * patches.largest);
        for (int p = static_cast<int>(begin); p < static_cast<int>(end); ++p) {
            const int first = patches.begin(p);
            const FacePatches::Way* const ways = patches.ways.data() + 3 * first;
            constexpr double none = -1.0;
            std::fill_n(trust.begin(), patches.size(p), none);
            const auto place = [&](int face, const Quaterniond& its_frame, double its_trust) {
                frame[to_size(face)] = its_frame;
                trust[to_size(face)] = its_trust;
                for (int h = 3 * face; h < 3 * face + 3; ++h)
                    if (ways[h].neighbour >= 0 && trust[to_size(ways[h].neighbour)] == none)
                        front.push(h, weights[ways[h].edge]);
            };
            place(0, Quaterniond::Identity(), 1.0);
            for (int h = front.pop(); h >= 0; h = front.pop()) {
                const auto [face, edge, from_left] = ways[h];
                if (trust[to_size(face)] == none)
                    place(face,
                          followed_by(frame[to_size(h / 3)], transitions[to_size(edge)], from_left),
                          std::min(trust[to_size(h / 3)], weights[edge]));
            }
            for (int i = 0; i < patches.size(p); ++i) {
                const int face = patches.faces[to_size(first + i)];
                frames[to_size(face)] = frame[to_size(i)];
                trust_[face] = trust[to_size(i)];
            }
        }
    });
}

/// G_p A = G_q for every bridge, A = L_f T L_g^T; and for every pair of patches with turns, where A
/// takes the reference from the frames of one patch to those of the other.
void PatchFrames::connect(const Rotations& transitions, const VectorXd& weights,
                          const Rotations& frames, const PatchTurning* turning)
{
    const FacePatches& patches = *patches_;
    // Neighbours that turn by nearly half a turn say little: their rotation vector is hardly unique.
    const auto share_of_turns = [&](std::size_t pair) {
        if (turning == nullptr)
            return 0.0;
        constexpr double least = 0.01; // no patch may come loose
        const double angle = turning->turns.segment<3>(3 * static_cast<Eigen::Index>(pair)).norm();
        return turning->share * std::max(least, 0.5 * (1.0 + std::cos(angle)));
    };
    Rotations of_patches; // from the reference to the patches as they are laid out
    if (turning != nullptr) {
        of_patches.resize(to_size(patches.count()));
        parallel_for(of_patches.size(), 64, [&](std::size_t begin, std::size_t end) {
            for (std::size_t p = begin; p < end; ++p)
                of_patches[p] = turning->reference.rotation(static_cast<int>(p), frames);
        });
    }
    std::vector<double> pair_weights(patches.pairs.size());
    parallel_for(pair_weights.size(), 256, [&](std::size_t begin, std::size_t end) {
        for (std::size_t k = begin; k < end; ++k) {
            const FacePatches::Pair& pair = patches.pairs[k];
            Matrix3d block = Matrix3d::Zero(); // rows of the higher patch, columns of the lower
            const double turned = share_of_turns(k);
            for (std::size_t b = pair.first_bridge; b < patches.end_bridge(k); ++b) {
                const auto [edge, lower, higher, from_left] = patches.bridges[b];
                // A frame that hangs by an edge of little trust has no say about other patches.
                const double weight =
                    (1.0 - turned) * weights[edge] * trust_[lower] * trust_[higher];
                const Quaterniond turn = followed_by(
                    followed_by(frames[to_size(lower)], transitions[to_size(edge)], from_left),
                    frames[to_size(higher)], false);
                block -= weight * turn.toRotationMatrix().transpose();
                pair_weights[k] += weight;
            }
            if (turning != nullptr) {
                const Eigen::Vector3d turn =
                    turning->turns.segment<3>(3 * static_cast<Eigen::Index>(k));
                const double weight =
                    turned * static_cast<double>(patches.end_bridge(k) - pair.first_bridge);
                const Quaterniond way = of_patches[to_size(pair.lower)] * rotation_by(turn) *
                                        of_patches[to_size(pair.higher)].conjugate();
                block -= weight * way.toRotationMatrix().transpose();
                pair_weights[k] += weight;
            }
            set_block(pair, block);
        }
    });
    factorise(pair_weights);
}

/// @param block  Rows of the higher patch, columns of the lower.
void PatchFrames::set_block(const FacePatches::Pair& pair, const Matrix3d& block)
{
    for (int i = 0; i < 3; ++i) {
        const int column = connection_.outerIndexPtr()[3 * pair.lower + i];
        Eigen::Vector3d::Map(connection_.valuePtr() + column + 1 + 3 * pair.rank) = block.col(i);
    }
}

void PatchFrames::factorise(const std::vector<double>& pair_weights)
{
    const FacePatches& patches = *patches_;
    VectorXd degree = VectorXd::Zero(patches.count());
    for (std::size_t k = 0; k < pair_weights.size(); ++k) {
        degree[patches.pairs[k].lower] += pair_weights[k];
        degree[patches.pairs[k].higher] += pair_weights[k];
    }
    // Where all loops close the matrix is singular: a shift far below its spectrum's gap.
    const double shift = 1e-9 * degree.mean();
    for (int column = 0; column < connection_.cols(); ++column)
        connection_.valuePtr()[connection_.outerIndexPtr()[column]] = degree[column / 3] + shift;
    factor_.refactor(connection_);
}

Rotations PatchFrames::face_frames(const Rotations& transitions, const VectorXd& weights,
                                   Rotations memory, const PatchTurning* turning)
{
    const FacePatches& patches = *patches_;
    if (transitions.size() != to_size(patches.edge_count) || weights.size() != patches.edge_count)
        throw InvalidInput(join("face frames: ", transitions.size(), " transitions and ",
                                weights.size(), " weights for ", patches.edge_count, " edges"));
    if (turning != nullptr &&
        turning->turns.size() != 3 * static_cast<Eigen::Index>(patches.pairs.size()))
        throw InvalidInput(join("face frames: ", turning->turns.size(), " numbers of turns for ",
                                patches.pairs.size(), " pairs of patches"));
    Rotations frames = std::move(memory);
    frames.resize(patches.faces.size());
    grow_trees(transitions, weights, frames);
    if (patches.count() == 1)
        return frames;
    connect(transitions, weights, frames, turning);
    const Eigen::MatrixXd vectors = smallest_eigenvectors(factor_);

    // The vectors are the rows of the matrices G; their common sign is free, a reflection is not.
    const auto block = [&](int p) { return Matrix3d(vectors.middleRows<3>(3 * p).transpose()); };
    double determinants = 0.0;
    for (int p = 0; p < patches.count(); ++p)
        determinants += block(p).determinant();
    const double sign = determinants < 0.0 ? -1.0 : 1.0;
    parallel_for(to_size(patches.count()), 64, [&](std::size_t begin, std::size_t end) {
        for (int p = static_cast<int>(begin); p < static_cast<int>(end); ++p) {
            const Quaterniond turn(nearest_rotation(sign * block(p)));
            for (int i = patches.begin(p); i < patches.begin(p + 1); ++i) {
                Quaterniond& frame = frames[to_size(patches.faces[to_size(i)])];
                frame = turn * frame;
            }
        }
    });
    return frames;
}

} // namespace shape::internal
