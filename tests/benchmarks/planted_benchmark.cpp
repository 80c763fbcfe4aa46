// SPDX-License-Identifier: MIT
//
// planted_benchmark stats MESHES SIDE MODES MEGABYTES
// planted_benchmark groups MESHES SIDE PERMUTATIONS MEGABYTES
//
// A collection that is made as it is read: grids of SIDE by SIDE vertices in the plane whose columns have the
// widths sqrt(p_i) and whose rows the heights sqrt(q_j). Then the squares of the edge lengths are p_i, q_j and
// p_i + q_j, linear in the parameters, and with cosines as modes of p and of q, and as scores, the spectrum of
// the squared lengths is known in closed form. Prints how far the variances found are from it, CPU seconds of
// all threads, and the largest resident set.
#include <sys/resource.h>

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <numbers>
#include <string>

#include "libshape/base/format.h"
#include "libshape/base/random.h"
#include "libshape/base/threads.h"
#include "libshape/base/to_size.h"
#include "libshape/model/streamed_fit.h"
#include "libshape/model/streamed_groups.h"

namespace {

using Eigen::Index;
using namespace shape;
using namespace shape::internal;

constexpr int mode_count = 300;   ///< In all, of p and q in turn.
constexpr double decay = 0.93;    ///< Of the variances.
constexpr double spread = 0.0009; ///< Of p and q, which are about 1.

double cosine(int k, Index i, Index count)
{
    return std::cos(std::numbers::pi * k * (static_cast<double>(i) + 0.5) /
                    static_cast<double>(count));
}

/// Amplitude of mode k, of p or q.
double amplitude(int k)
{
    return spread * std::pow(decay, 0.5 * k);
}

/// Faces of a grid, each square cut along the same diagonal.
Faces grid_faces(int side)
{
    Faces faces(2 * (side - 1) * (side - 1), 3);
    int f = 0;
    for (int j = 0; j + 1 < side; ++j)
        for (int i = 0; i + 1 < side; ++i) {
            const int a = j * side + i;
            faces.row(f++) << a, a + 1, a + side + 1;
            faces.row(f++) << a, a + side + 1, a + side;
        }
    return faces;
}

class Grids
{
public:
    Grids(Index meshes, int side)
        : meshes_(meshes), side_(side), waves_(side - 1, std::min(mode_count / 2, side - 2))
    {
        for (Index k = 0; k < waves_.cols(); ++k)
            for (Index i = 0; i < waves_.rows(); ++i)
                waves_(i, k) = cosine(static_cast<int>(k) + 1, i, waves_.rows());
    }

    [[nodiscard]] MeshStream stream() const
    {
        MeshStream stream{Topology(grid_faces(side_), side_ * side_), {}, {}, 0, {}};
        stream.bytes_per_mesh = sizeof(double) * 3 * to_size(Index{side_} * side_);
        for (Index i = 0; i < meshes_; ++i)
            stream.names.push_back(join("m", i));
        stream.fetch = [this](std::vector<Index> chosen) -> MeshStream::Unpack {
            return [this, chosen = std::move(chosen)](std::span<Points> points) {
                parallel_for(points.size(), 1,
                             [&](std::size_t i, std::size_t) { make(chosen[i], points[i]); });
            };
        };
        return stream;
    }

    /// Of mode k: N - 1 times it is the square of the amplitude and of the length of the mode.
    [[nodiscard]] double variance(int k) const
    {
        const double copies = 2.0 * side_ - 1.0; // edges that have a p_i: rows and diagonals
        return amplitude(k) * amplitude(k) * copies * 0.5 * (side_ - 1) * 0.5 *
               static_cast<double>(meshes_) / static_cast<double>(meshes_ - 1);
    }
    [[nodiscard]] int modes() const { return static_cast<int>(2 * waves_.cols()); }

private:
    void make(Index mesh, Points& points) const
    {
        const Index half = waves_.cols();
        Eigen::VectorXd p(half), q(half); // shares of the modes
        for (Index k = 0; k < half; ++k) {
            const int number = static_cast<int>(2 * k);
            p[k] = amplitude(number) * cosine(number + 1, mesh, meshes_);
            q[k] = amplitude(number + 1) * cosine(number + 2, mesh, meshes_);
        }
        const Eigen::VectorXd widths = (1.0 + (waves_ * p).array()).sqrt();
        const Eigen::VectorXd heights = (1.0 + (waves_ * q).array()).sqrt();
        double y = 0.0;
        for (int j = 0; j < side_; ++j) {
            double x = 0.0;
            for (int i = 0; i < side_; ++i) {
                points.row(Index{j} * side_ + i) << x, y, 0.0;
                x += i + 1 < side_ ? widths[i] : 0.0;
            }
            y += j + 1 < side_ ? heights[j] : 0.0;
        }
    }

    Index meshes_;
    int side_;
    Eigen::MatrixXd waves_;
};

void report_costs()
{
    rusage usage{};
    getrusage(RUSAGE_SELF, &usage);
    const auto seconds = [](const timeval& time) {
        return static_cast<double>(time.tv_sec) + 1e-6 * static_cast<double>(time.tv_usec);
    };
    std::printf("%.0f CPU s, %.0f MB\n", seconds(usage.ru_utime) + seconds(usage.ru_stime),
                static_cast<double>(usage.ru_maxrss) / 1000.0);
}

} // namespace

int main(int argc, char** argv)
{
    if (argc != 6)
        return std::fputs("planted_benchmark stats|groups MESHES SIDE MODES|PERMUTATIONS MB\n",
                          stderr),
               2;
    const Grids grids(std::atoi(argv[2]), std::atoi(argv[3]));
    const int number = std::atoi(argv[4]);
    const std::uint64_t memory = std::strtoull(argv[5], nullptr, 10) * 1000000;
    const MeshStream meshes = grids.stream();
    const SpaceOptions space{.scale = Scale::None, .coordinates = LengthCoordinates::Squared};
    std::printf("%td meshes, %d vertices, %d edges: ", meshes.size(),
                meshes.topology.vertex_count(), meshes.topology.edge_count());
    if (std::string(argv[1]) == "stats") {
        const StreamedFit fit =
            fit_model(meshes, {.modes = number, .space = space}, {.memory = memory});
        double error = 0.0;
        double total = 0.0;
        for (int k = 0; k < grids.modes(); ++k)
            total += grids.variance(k);
        for (int k = 0; k < number; ++k)
            error = std::max(error, std::abs(fit.model.variances[k] / grids.variance(k) - 1.0));
        std::printf(
            "%d modes by %s in %d passes; variances within %.1e of the planted ones "
            "(estimated %.1e), all of them within %.1e; ",
            number, fit.algorithm == FitAlgorithm::Gram ? "gram" : "krylov", fit.passes, error,
            fit.error, std::abs(fit.model.total_variance / total - 1.0));
    } else {
        Random random(1);
        std::vector<std::string> labels;
        for (Index i = 0; i < meshes.size(); ++i)
            labels.push_back(random.uniform() < 0.4 ? "a" : "b");
        StreamedGroupsOptions options;
        options.space = space;
        options.permutations.permutations = number;
        options.memory = memory;
        const StreamedGroups found =
            compare_groups(meshes, group_by(labels), groups_of_one(meshes.size()), options);
        double total = 0.0;
        for (int k = 0; k < grids.modes(); ++k)
            total += grids.variance(k) * static_cast<double>(meshes.size() - 1);
        std::printf(
            "groups with %d permutations and 1000 replicates in %d passes; F = %.4f, "
            "p = %.3f; the sum of squares is within %.1e of the planted one; ",
            number, found.passes, found.comparison.overall.f, found.comparison.overall.p_value,
            std::abs(found.comparison.overall.total_sum_of_squares / total - 1.0));
    }
    report_costs();
    return 0;
}
