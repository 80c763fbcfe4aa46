// SPDX-License-Identifier: MIT

#include "libshape/embedding/energy/length_dihedral_energy.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

#include "libshape/base/error.h"
#include "libshape/base/format.h"
#include "libshape/base/gathered_vectors.h"
#include "libshape/base/threads.h"
#include "libshape/base/to_size.h"
#include "libshape/base/vector_math.h"
#include "libshape/base/vectorised.h"
#include "libshape/edge_space/angle_limit.h"
#include "libshape/embedding/energy/stretch_term.h"
#include "libshape/mesh/dihedral_angles.h"
#include "libshape/mesh/hinge.h"
#include "libshape/mesh/triangle_area.h"

namespace shape::internal {

using Eigen::Vector3d;
using Eigen::VectorXd;

namespace {

// One evaluation of E and its gradient runs over the mesh four times, each loop in blocks of 128 that the
// first cache holds (base/blocks.h):
//
//     faces     n = (b - a) x (c - a),   1 / |n|^2                                    face_normals()
//     edges     l,  theta - theta*,  the term E_e,  dE/dl / l,  dE/dtheta             bends(), edge_terms()
//     faces     what the angles of its edges lift every corner along n                corner_lifts()
//     vertices  dE/dx = sum over edges (dE/dl / l) (x - y) + sum over faces lift n    gather_gradient()
//
// The plain loop over edges would add to four vertices an edge: threads would have to take turns, and the
// sums would depend on them; it would also compute every normal three times. Here each loop writes
// what is its own. In memory a block is first copied from the rows of three, as the mesh has them,
//
//     points   x0 y0 z0 x1 y1 z1 ...     to     x: x0 x1 .. x127   y: y0 y1 .. y127   z: z0 z1 .. z127
//
// so that the arithmetic is on whole registers, two or four vectors at once, without a branch.

/// Normals as long as twice the area, and their inverse squares, bounded for heights below 1e-3 of
/// the sides: angles change abruptly where such a face turns over, and it must not dominate the step.
SHAPE_VECTORISED void face_normals(int count, const VectorRows& a, const VectorRows& b,
                                   const VectorRows& c, VectorRows& __restrict normals,
                                   double* __restrict inverse_squares)
{
    for (int i = 0; i < count; ++i) {
        const Vector3<double> p = b[i] - a[i];
        const Vector3<double> q = c[i] - a[i];
        const Vector3<double> normal = cross(p, q);
        normals.set(i, normal);
        const double bounded = std::max(dot(normal, normal), 1e-6 * dot(p, p) * dot(q, q));
        inverse_squares[i] = bounded > 0.0 ? 1.0 / bounded : 0.0;
    }
}

/// Lengths of edges p - q, and a vector in the direction theta - theta* (mesh/hinge.h).
SHAPE_VECTORISED void bends(int count, const VectorRows& p, const VectorRows& q,
                            const VectorRows& left, const VectorRows& right, const double* sines,
                            const double* cosines, double* __restrict lengths,
                            double* __restrict bend_sines, double* __restrict bend_cosines)
{
    for (int i = 0; i < count; ++i) {
        const Vector3<double> edge = q[i] - p[i];
        const double length = std::sqrt(dot(edge, edge));
        const auto bend =
            turned_back(hinge_angle(edge, length, left[i], right[i]), sines[i], cosines[i]);
        lengths[i] = length;
        bend_sines[i] = bend.sine;
        bend_cosines[i] = bend.cosine;
    }
}

/// What every edge adds to the energy, dE/dl / l, and dE/dtheta in the place of theta - theta*.
SHAPE_VECTORISED void edge_terms(int count, double stiffness, const double* bend_weights,
                                 const double* lengths, const double* inverse_lengths,
                                 double* __restrict energies, double* __restrict pulls,
                                 double* __restrict angles)
{
    const double inverse_square = 1.0 / (stiffness * stiffness);
    for (int i = 0; i < count; ++i) {
        const double strain = lengths[i] * inverse_lengths[i] - 1.0;
        const auto [value, weight] = stretch_term(stiffness * strain);
        energies[i] = inverse_square * value + bend_weights[i] * angles[i] * angles[i];
        pulls[i] = lengths[i] > 0.0 ? 2.0 * weight * strain * inverse_lengths[i] / lengths[i] : 0.0;
        angles[i] *= 2.0 * bend_weights[i];
    }
}

/// What the angles of every face add to the gradient at its corners, as multiples of its normal; of
/// edge quantities x, y, z belong to the edges 0-1, 1-2, 2-0.
SHAPE_VECTORISED void corner_lifts(int count, const double* inverse_squares,
                                   const VectorRows& lengths, const VectorRows& moments,
                                   VectorRows& __restrict lifts)
{
    for (int i = 0; i < count; ++i) {
        const auto [a, b, c] = lengths[i];
        const auto [u, v, w] = moments[i];
        const double aa = a * a, bb = b * b, cc = c * c;
        const HingeShares<double> over_a = hinge_shares(a, foot_of(a, aa, cc, bb));
        const HingeShares<double> over_b = hinge_shares(b, foot_of(b, bb, aa, cc));
        const HingeShares<double> over_c = hinge_shares(c, foot_of(c, cc, bb, aa));
        lifts.set(i, {inverse_squares[i] * (u * over_a.a + v * over_b.c + w * over_c.b),
                      inverse_squares[i] * (v * over_b.a + w * over_c.c + u * over_a.b),
                      inverse_squares[i] * (w * over_c.a + u * over_a.c + v * over_b.b)});
    }
}

/// The gradient at vertices [begin, end), from lifts of corners and pulls of edges.
SHAPE_VECTORISED void gather_gradient(int begin, int end, const Topology& topology,
                                      const double* points, const double* normals,
                                      const double* lifts, const double* pulls,
                                      double* __restrict gradient)
{
    for (int v = begin; v < end; ++v) {
        const double* const here = points + 3 * v;
        double x = 0.0, y = 0.0, z = 0.0;
        for (const Topology::Spoke& spoke : topology.spokes(v)) {
            const double* const there = points + 3 * spoke.vertex;
            const double pull = pulls[spoke.edge];
            x += pull * (here[0] - there[0]);
            y += pull * (here[1] - there[1]);
            z += pull * (here[2] - there[2]);
            if (spoke.halfedge < 0)
                break;
            const double* const normal = normals + 3 * (spoke.halfedge / 3);
            const double lift = lifts[spoke.halfedge];
            x += lift * normal[0];
            y += lift * normal[1];
            z += lift * normal[2];
        }
        gradient[3 * v] = x;
        gradient[3 * v + 1] = y;
        gradient[3 * v + 2] = z;
    }
}

/// bend_weights().
VectorXd trusted_bends(const Topology& topology, const VectorXd& lengths, double smoothness)
{
    // Of mu: what is beside a sliver is still held by a little, as its lengths hardly do. How little was
    // not varied on record; the onset, sliver_shape, was (docs/experiments/embedding.md).
    constexpr double least = 0.01;
    VectorXd of_faces(topology.face_count());
    for_blocks(topology.face_count(), [&](int first, int count) {
        for (int f = first; f < first + count; ++f) {
            const int* const e = topology.face_edges().data() + 3 * f;
            const double a = lengths[e[0]], b = lengths[e[1]], c = lengths[e[2]];
            const double longest = std::max({a, b, c});
            const double q2 = 0.25 * sixteen_squared_areas(a / longest, b / longest, c / longest);
            of_faces[f] = smoothness * std::clamp(q2 / (sliver_shape * sliver_shape), least, 1.0);
        }
    });
    VectorXd weights(topology.edge_count());
    for_blocks(topology.edge_count(), [&](int first, int count) {
        for (int e = first; e < first + count; ++e) {
            const int* const h = topology.edge_halfedges().data() + 2 * e;
            weights[e] = h[1] < 0 ? 0.0 : std::min(of_faces[h[0] / 3], of_faces[h[1] / 3]);
        }
    });
    return weights;
}

} // namespace

LengthDihedralEnergy::LengthDihedralEnergy(const Topology& topology, ShapePoint target,
                                           double smoothness)
    : topology_(topology), target_(std::move(target))
{
    const int edges = topology.edge_count();
    if (target_.edge_lengths.size() != edges || target_.dihedral_angles.size() != edges)
        throw InvalidInput(join("target has ", target_.edge_lengths.size(), " lengths and ",
                                target_.dihedral_angles.size(), " dihedral angles, the topology ",
                                edges, " edges"));
    for (int e = 0; e < edges; ++e)
        if (!(target_.edge_lengths[e] > 0.0 && std::isfinite(target_.edge_lengths[e]) &&
              is_within_angle_limit(target_.dihedral_angles[e])))
            throw InvalidInput(
                join("target: edge ", e, " (", topology.edges()(e, 0), "-", topology.edges()(e, 1),
                     ") has length ", target_.edge_lengths[e], " and dihedral angle ",
                     target_.dihedral_angles[e], "; lengths must be > 0 and finite, angles within ",
                     angle_limit, " rad"));
    if (!(smoothness > 0.0 && std::isfinite(smoothness)))
        throw InvalidInput(join("smoothness is ", smoothness, ", must be > 0 and finite"));
    bend_weights_ = trusted_bends(topology, target_.edge_lengths, smoothness);
    inverse_lengths_ = target_.edge_lengths.cwiseInverse();
    sines_.resize(edges);
    cosines_.resize(edges);
    sines_cosines(target_.dihedral_angles.data(), to_size(edges), sines_.data(), cosines_.data());
    for (int e = 0; e < edges; ++e)
        if (topology.is_boundary_edge(e)) {
            sines_[e] = 0.0;
            cosines_[e] = 1.0;
        }
}

void LengthDihedralEnergy::want_lengths(const VectorXd& lengths)
{
    target_.edge_lengths = lengths;
    inverse_lengths_ = lengths.cwiseInverse();
}

void LengthDihedralEnergy::stiffen(double stiffness)
{
    stiffness_ = stiffness;
}

void LengthDihedralEnergy::keep_areas()
{
    const Topology& t = topology_;
    const VectorXd& l = target_.edge_lengths;
    areas_kept_ = true;
    least_squares_.resize(t.face_count());
    for (int f = 0; f < t.face_count(); ++f) {
        const auto e = t.face_edges().row(f);
        least_squares_[f] =
            0.25 * 0.25 * std::max(0.0, sixteen_squared_areas(l[e[0]], l[e[1]], l[e[2]]));
    }
}

void LengthDihedralEnergy::hold_near(VectorXd points, double weight)
{
    const Topology& t = topology_;
    const auto point = [&](int v) -> Vector3d { return points.segment<3>(3 * v); };
    VectorXd shares = VectorXd::Zero(t.vertex_count());
    for (int f = 0; f < t.face_count(); ++f) {
        const auto corners = t.faces().row(f);
        const Vector3d a = point(corners[0]);
        const double area = (point(corners[1]) - a).cross(point(corners[2]) - a).norm();
        for (const int v : corners)
            shares[v] += area;
    }
    shares /= shares.sum();
    const auto rows = points.reshaped<Eigen::RowMajor>(t.vertex_count(), 3);
    const Eigen::RowVector3d centre = shares.transpose() * rows;
    const double square = 12.0 * shares.dot((rows.rowwise() - centre).rowwise().squaredNorm());
    hold_weights_ = weight * t.edge_count() / square * shares;
    held_points_ = std::move(points);
}

double LengthDihedralEnergy::hold_energy(const VectorXd& points) const
{
    return parallel_sum(
        to_size(hold_weights_.size()), 8 * block_size, [&](std::size_t begin, std::size_t end) {
            double sum = 0.0;
            for (auto v = static_cast<Eigen::Index>(begin); v < static_cast<Eigen::Index>(end); ++v)
                sum += hold_weights_[v] *
                       (points.segment<3>(3 * v) - held_points_.segment<3>(3 * v)).squaredNorm();
            return sum;
        });
}

void LengthDihedralEnergy::hold_sums(std::vector<AngleSum> sums)
{
    for (const AngleSum& sum : sums) {
        if (sum.factors.size() != sum.edges.size() || sum.aims.size() != sum.edges.size())
            throw InvalidInput(join("a sum of angles has ", sum.edges.size(), " edges, ",
                                    sum.factors.size(), " factors and ", sum.aims.size(), " aims"));
        for (const int e : sum.edges)
            if (topology_.is_boundary_edge(e))
                throw InvalidInput(join("a sum of angles has edge ", e, " of the boundary"));
    }
    held_sums_ = std::move(sums);
}

void LengthDihedralEnergy::keep_apart(std::vector<Gap> gaps)
{
    for (const Gap& gap : gaps)
        if (gap.factors.size() != gap.vertices.size())
            throw InvalidInput(join("a gap has ", gap.vertices.size(), " vertices and ",
                                    gap.factors.size(), " factors"));
    gaps_ = std::move(gaps);
}

double LengthDihedralEnergy::lack(const Gap& gap, const VectorXd& points)
{
    double reached = 0.0;
    for (std::size_t i = 0; i < gap.vertices.size(); ++i)
        reached += gap.factors[i] * gap.direction.dot(points.segment<3>(3 * gap.vertices[i]));
    return std::max(0.0, gap.least - reached);
}

double LengthDihedralEnergy::gap_energy(const VectorXd& points) const
{
    double energy = 0.0;
    for (const Gap& gap : gaps_) {
        const double lacking = lack(gap, points);
        energy += gap.stiffness * lacking * lacking;
    }
    return energy;
}

void LengthDihedralEnergy::add_gaps(const VectorXd& points, VectorXd& gradient) const
{
    for (const Gap& gap : gaps_) {
        const double lacking = lack(gap, points);
        for (std::size_t i = 0; i < gap.vertices.size(); ++i)
            gradient.segment<3>(3 * gap.vertices[i]) -=
                2.0 * gap.stiffness * lacking * gap.factors[i] * gap.direction;
    }
}

/// What held sums add to E, and to its gradient by the moments of their edges.
double LengthDihedralEnergy::add_sums()
{
    std::vector<double> misses; // all before any moment changes: sums may share edges
    for (const AngleSum& sum : held_sums_) {
        double& missed = misses.emplace_back(0.0);
        for (std::size_t i = 0; i < sum.edges.size(); ++i) {
            const int e = sum.edges[i];
            const double bend = 0.5 * moments_[e] / bend_weights_[e];
            missed +=
                sum.factors[i] * wrapped_angle(bend + target_.dihedral_angles[e] - sum.aims[i]);
        }
    }
    double energy = 0.0;
    for (std::size_t k = 0; k < misses.size(); ++k) {
        const AngleSum& sum = held_sums_[k];
        for (std::size_t i = 0; i < sum.edges.size(); ++i)
            moments_[sum.edges[i]] += 2.0 * sum.stiffness * misses[k] * sum.factors[i];
        energy += sum.stiffness * misses[k] * misses[k];
    }
    return energy;
}

/// Faces below half of their areas: what they add to E, to the energies of one of their edges, and to
/// its gradient, to the pulls of all three; d|n| / dl = l cot(opposite angle), n as long as 2 A.
void LengthDihedralEnergy::add_collapses(const VectorXd& points)
{
    // Enough that no face lost its area in the 93 meshes where 18 had some that did (docs/experiments/embedding.md);
    // a face a tenth as large as wanted then costs 0.026, about as an edge stretched by 10 %.
    constexpr double beta = 0.01;
    const Topology& t = topology_;
    collapses_.clear();
    for (int f = 0; f < t.face_count(); ++f) {
        if (!(inverse_squares_[f] * least_squares_[f] > 1.0))
            continue;
        const Vector3d normal = normals_.row(f);
        const double square = normal.squaredNorm();
        // Twice an area below 1e-15 of the wanted one is rounding: nothing says which way it would grow.
        if (!(square > 1e-30 * least_squares_[f]))
            continue;
        const double residual = 0.5 * std::sqrt(beta) * std::log(least_squares_[f] / square);
        const double pull = std::sqrt(beta) / square;
        const auto corner = [&](int k) -> Vector3d {
            return points.segment<3>(3 * t.faces()(f, k % 3));
        };
        const auto by_corner = [&](int k) -> Vector3d {
            return pull * normal.cross(corner(k + 1) - corner(k + 2));
        };
        collapses_.push_back({f, residual, {by_corner(0), by_corner(1), by_corner(2)}});
        energies_[t.face_edges()(f, 0)] += residual * residual;
        for (int k = 0; k < 3; ++k)
            pulls_[t.face_edges()(f, k)] -=
                2.0 * residual * pull *
                (corner(k) - corner(k + 2)).dot(corner(k + 1) - corner(k + 2));
    }
}

void LengthDihedralEnergy::measure_edges(const VectorXd& points)
{
    const Topology& t = topology_;
    for (VectorXd* const of_edges : {&lengths_, &energies_, &pulls_, &moments_})
        of_edges->resize(t.edge_count());
    for_blocks(t.edge_count(), [&](int first, int count) {
        int left_faces[block_size], right_faces[block_size];
        for (int i = 0; i < count; ++i) {
            const int* const halfedges = t.edge_halfedges().data() + 2 * (first + i);
            left_faces[i] = Topology::face(halfedges[0]);
            right_faces[i] =
                Topology::face(halfedges[halfedges[1] < 0 ? 0 : 1]); // flat at the boundary
        }
        const int* const ends = t.edges().data() + 2 * first;
        VectorRows p, q, left, right;
        gather(count, points.data(), {ends, 2}, p);
        gather(count, points.data(), {ends + 1, 2}, q);
        gather(count, normals_.data(), {left_faces}, left);
        gather(count, normals_.data(), {right_faces}, right);
        Row sines, cosines;
        bends(count, p, q, left, right, sines_.data() + first, cosines_.data() + first,
              lengths_.data() + first, sines, cosines);
        double* const angles = moments_.data() + first;
        vector_angles(sines, cosines, to_size(count), angles);
        edge_terms(count, stiffness_, bend_weights_.data() + first, lengths_.data() + first,
                   inverse_lengths_.data() + first, energies_.data() + first, pulls_.data() + first,
                   angles);
    });
}

void LengthDihedralEnergy::add_hold(const VectorXd& points, VectorXd& gradient) const
{
    if (hold_weights_.size() == 0)
        return;
    for_blocks(topology_.vertex_count(), [&](int first, int count) {
        for (int v = first; v < first + count; ++v)
            gradient.segment<3>(3 * v) +=
                2.0 * hold_weights_[v] *
                (points.segment<3>(3 * v) - held_points_.segment<3>(3 * v));
    });
}

double LengthDihedralEnergy::evaluate(const VectorXd& points)
{
    const Topology& t = topology_;
    const int* const faces = t.faces().data();
    normals_.resize(t.face_count(), 3);
    inverse_squares_.resize(t.face_count());
    for_blocks(t.face_count(), [&](int first, int count) {
        VectorRows p, q, r, normal;
        const int* const corners = faces + 3 * first;
        gather(count, points.data(), {corners, 3}, p);
        gather(count, points.data(), {corners + 1, 3}, q);
        gather(count, points.data(), {corners + 2, 3}, r);
        face_normals(count, p, q, r, normal, inverse_squares_.data() + first);
        for (int i = 0; i < count; ++i)
            store(normal[i], normals_.data() + 3 * (first + i));
    });
    measure_edges(points);

    if (areas_kept_)
        add_collapses(points);
    const double of_sums = add_sums();
    double energy = parallel_sum(
        to_size(t.edge_count()), 8 * block_size, [&](std::size_t begin, std::size_t end) {
            return std::accumulate(energies_.data() + begin, energies_.data() + end, 0.0);
        });
    energy += of_sums + gap_energy(points);
    if (hold_weights_.size() > 0)
        energy += hold_energy(points);
    return energy;
}

void LengthDihedralEnergy::find_gradient(const VectorXd& points, VectorXd& gradient)
{
    const Topology& t = topology_;
    const int* const face_edges = t.face_edges().data();
    lifts_.resize(t.halfedge_count());
    for_blocks(t.face_count(), [&](int first, int count) {
        VectorRows length{}, moment{}, lift{};
        for (int i = 0; i < count; ++i) {
            const int* const e = face_edges + 3 * (first + i);
            length.set(i, {lengths_[e[0]], lengths_[e[1]], lengths_[e[2]]});
            moment.set(i, {moments_[e[0]], moments_[e[1]], moments_[e[2]]});
        }
        corner_lifts(count, inverse_squares_.data() + first, length, moment, lift);
        for (int i = 0; i < count; ++i)
            store(lift[i], lifts_.data() + 3 * (first + i));
    });

    gradient.resize(points.size());
    parallel_for(to_size(t.vertex_count()), 512, [&](std::size_t begin, std::size_t end) {
        gather_gradient(static_cast<int>(begin), static_cast<int>(end), t, points.data(),
                        normals_.data(), lifts_.data(), pulls_.data(), gradient.data());
    });
    add_gaps(points, gradient);
    add_hold(points, gradient);
}

double LengthDihedralEnergy::evaluate(const VectorXd& points, VectorXd& gradient)
{
    const double energy = evaluate(points);
    find_gradient(points, gradient);
    return energy;
}

} // namespace shape::internal
