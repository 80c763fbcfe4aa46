// SPDX-License-Identifier: MIT

#include "libshape/embedding/start/face_fit.h"

#include <array>
#include <cmath>

#include "libshape/base/blocks.h"
#include "libshape/base/to_size.h"
#include "libshape/base/vectorised.h"
#include "libshape/embedding/start/quaternion_rows.h"
#include "libshape/mesh/rotation_fit.h"

namespace shape::internal {
namespace {

using Eigen::Matrix3d;
using Eigen::Quaterniond;
using Eigen::Vector2d;

/// Sums of w (x_b - x_a) u^T over edges a-b that lie along u: row by row.
struct Covariances
{
    std::array<Row, 9> entries;

    [[nodiscard]] Matrix3d get(int i) const
    {
        Matrix3d m;
        for (int k = 0; k < 9; ++k)
            m(k / 3, k % 3) = entries[to_size(k)][i];
        return m;
    }
};

/// A side of a face and what lies across it.
struct Side
{
    Row u, v;         ///< The side in the plane of the face,
    Row weight;       ///< in all.
    VectorRows apex;  ///< Where the third corner of the neighbour is.
    Row out_u, out_v; ///< The neighbour's edge from the first corner to its apex in its own plane,
    QuaternionRows turn; ///< its frame,
    Row near_w, far_w;   ///< and the weights of its edges there from the first and second corner.
};

/// Adds a side from p to q and half of the neighbour behind it:
///
///     M += w (q - p) u^T + near (apex - p) n^T + far (q - apex) f^T,      f = u - n,
///
///            apex            u, n, f are the edges as they are laid out in the frame of the face: u from p
///           /    `.          to q in its plane, n = R(turn) (a, b, 0), the edge of the neighbour in its own
///        n /       `. f      plane turned by the transition between the frames.
///         /   u      `.
///        p ----------- q     As u and the sum of n and f have no z, M gets (near - far) n there.
///
/// In memory a coordinate of 128 faces is a row, as is an entry of their M:
///
///     p.x: x0 x1 .. x127     side.u: u0 u1 .. u127     m[3 r + c]: M_rc of face 0, of face 1, ...
///
/// The plain loop over faces multiplies vectors of three, and builds a matrix for each quaternion: most
/// of a register is empty. Here a lane is a face, and a boundary side is a neighbour without weight
/// rather than a branch.
SHAPE_VECTORISED void add_side(int count, const Side& side, const VectorRows& p,
                               const VectorRows& q, Covariances& __restrict sums)
{
    auto& m = sums.entries;
    for (int i = 0; i < count; ++i) {
        const double w = side.turn.w[i], x = side.turn.x[i], y = side.turn.y[i], z = side.turn.z[i];
        const double a = side.out_u[i], b = side.out_v[i];
        // The neighbour's edges as seen from the face: n from p to the apex, f from there to q.
        const double nx = a * (1.0 - 2.0 * (y * y + z * z)) + b * (2.0 * (x * y - w * z));
        const double ny = a * (2.0 * (x * y + w * z)) + b * (1.0 - 2.0 * (x * x + z * z));
        const double nz = a * (2.0 * (x * z - w * y)) + b * (2.0 * (y * z + w * x));
        const double fx = side.u[i] - nx;
        const double fy = side.v[i] - ny;
        const auto add = [&](double from, double to, double apex, double& to_x, double& to_y,
                             double& to_z) {
            const double own = side.weight[i] * (to - from);
            const double near = side.near_w[i] * (apex - from);
            const double far = side.far_w[i] * (to - apex);
            to_x += own * side.u[i] + near * nx + far * fx;
            to_y += own * side.v[i] + near * ny + far * fy;
            to_z += (near - far) * nz;
        };
        add(p.x[i], q.x[i], side.apex.x[i], m[0][i], m[1][i], m[2][i]);
        add(p.y[i], q.y[i], side.apex.y[i], m[3][i], m[4][i], m[5][i]);
        add(p.z[i], q.z[i], side.apex.z[i], m[6][i], m[7][i], m[8][i]);
    }
}

/// Turns frames to the nearest rotations of matrices, as mesh/rotation_fit.h does, where they are
/// not far: `found` is 1 there, elsewhere 0.
///
/// With s = R^T M, the quaternion (1, v) of the turn is the eigenvector of the largest eigenvalue
/// trace(s) + t of a symmetric matrix: (A + t) v = z, t = z . v with A = 2 trace(s) - s - s^T.
/// Newton's method finds t from 0; it grows towards the solution if A is positive definite.
///
/// In memory as in add_side(): a row an entry of s, A, their cofactors, the quaternion. The plain loop
/// would stop as soon as a face has converged or is found far; here all lanes take the same four steps,
/// and what is not near is left to rotation_fit.h by the caller.
SHAPE_VECTORISED void turn_frames(int count, const Covariances& sums,
                                  QuaternionRows& __restrict frames, double* __restrict found)
{
    constexpr int steps = 4;         // of Newton's method: digits double, and frames turn little
    constexpr double max_turn = 0.5; // |tan(angle / 2)|^2: beyond 70 degrees another branch is near
    constexpr double rounding = 1e-14; // of t, over the trace
    constexpr double flat_limit =
        1e-12; // determinant over cubed trace: a line, any turn about it fits
    const auto& m = sums.entries;
    for (int i = 0; i < count; ++i) {
        const double qw = frames.w[i], qx = frames.x[i], qy = frames.y[i], qz = frames.z[i];
        const double r00 = 1.0 - 2.0 * (qy * qy + qz * qz), r01 = 2.0 * (qx * qy - qw * qz),
                     r02 = 2.0 * (qx * qz + qw * qy);
        const double r10 = 2.0 * (qx * qy + qw * qz), r11 = 1.0 - 2.0 * (qx * qx + qz * qz),
                     r12 = 2.0 * (qy * qz - qw * qx);
        const double r20 = 2.0 * (qx * qz - qw * qy), r21 = 2.0 * (qy * qz + qw * qx),
                     r22 = 1.0 - 2.0 * (qx * qx + qy * qy);
        const double s00 = r00 * m[0][i] + r10 * m[3][i] + r20 * m[6][i];
        const double s01 = r00 * m[1][i] + r10 * m[4][i] + r20 * m[7][i];
        const double s02 = r00 * m[2][i] + r10 * m[5][i] + r20 * m[8][i];
        const double s10 = r01 * m[0][i] + r11 * m[3][i] + r21 * m[6][i];
        const double s11 = r01 * m[1][i] + r11 * m[4][i] + r21 * m[7][i];
        const double s12 = r01 * m[2][i] + r11 * m[5][i] + r21 * m[8][i];
        const double s20 = r02 * m[0][i] + r12 * m[3][i] + r22 * m[6][i];
        const double s21 = r02 * m[1][i] + r12 * m[4][i] + r22 * m[7][i];
        const double s22 = r02 * m[2][i] + r12 * m[5][i] + r22 * m[8][i];
        const double zx = s21 - s12, zy = s02 - s20, zz = s10 - s01;
        const double a01 = -(s01 + s10), a02 = -(s02 + s20), a12 = -(s12 + s21);
        const double trace = s00 + s11 + s22;
        double t = 0.0, change = 0.0, x = 0.0, y = 0.0, z = 0.0, square = 0.0;
        bool positive = true;
        for (int step = 0; step < steps; ++step) {
            const double a00 = 2.0 * (s11 + s22) + t;
            const double a11 = 2.0 * (s00 + s22) + t;
            const double a22 = 2.0 * (s00 + s11) + t;
            const double c00 = a11 * a22 - a12 * a12;
            const double c01 = a02 * a12 - a01 * a22;
            const double c02 = a01 * a12 - a02 * a11;
            const double c11 = a00 * a22 - a02 * a02;
            const double c12 = a01 * a02 - a00 * a12;
            const double c22 = a00 * a11 - a01 * a01;
            const double determinant = a00 * c00 + a01 * c01 + a02 * c02;
            const double limit = 64.0 * flat_limit * trace * trace * trace;
            positive = positive & (a11 > 0.0) & (c00 > 0.0) & (determinant > limit);
            const double inverse = 1.0 / determinant;
            x = (c00 * zx + c01 * zy + c02 * zz) * inverse;
            y = (c01 * zx + c11 * zy + c12 * zz) * inverse;
            z = (c02 * zx + c12 * zy + c22 * zz) * inverse;
            square = x * x + y * y + z * z;
            change = zx * x + zy * y + zz * z - t;
            t += change / (1.0 + square);
        }
        const double w = qw - qx * x - qy * y - qz * z;
        const double wx = qw * x + qx + qy * z - qz * y;
        const double wy = qw * y + qy + qz * x - qx * z;
        const double wz = qw * z + qz + qx * y - qy * x;
        const double scale = 1.0 / std::sqrt(w * w + wx * wx + wy * wy + wz * wz);
        const bool near = positive & (square < max_turn) & (change < rounding * trace);
        frames.w[i] = near ? scale * w : qw;
        frames.x[i] = near ? scale * wx : qx;
        frames.y[i] = near ? scale * wy : qy;
        frames.z[i] = near ? scale * wz : qz;
        found[i] = near ? 1.0 : 0.0;
    }
}

} // namespace

Rotations fit_faces(const Topology& topology, const FaceLayout& layout,
                    const Eigen::VectorXd& weights, const Points& points, Rotations frames)
{
    const int* const faces = topology.faces().data();
    const int* const face_edges = topology.face_edges().data();
    const auto position = [&](int vertex) { return vector3(points.data() + 3 * vertex); };
    const auto gather_side = [&](int i, int face, int c, Side& side) {
        constexpr std::array<int, 3> next{1, 2, 0}, previous{2, 0, 1};
        const int h = 3 * face + c;
        const int opposite = topology.opposite(h);
        const bool alone = opposite < 0; // a neighbour without weight
        const int other = (alone ? h : opposite) / 3;
        const auto corner = to_size((alone ? h : opposite) - 3 * other);
        const int near = 3 * other + next[corner];
        const int far = 3 * other + previous[corner];
        const Vector2d along = layout.halfedge(face, c);
        const Vector2d out = layout.halfedge(other, next[corner]);
        const int edge = face_edges[h];
        const double way = 2.0 * (topology.edge_halfedges()(edge, 0) == h) - 1.0;
        side.u[i] = along.x();
        side.v[i] = along.y();
        side.weight[i] = (alone ? 1.0 : 1.5) * weights[edge]; // half of it the neighbour's
        side.apex.set(i, position(faces[far]));
        side.out_u[i] = out.x();
        side.out_v[i] = out.y();
        side.turn.set(i, layout.transitions[to_size(edge)], way);
        side.near_w[i] = alone ? 0.0 : 0.5 * weights[face_edges[near]];
        side.far_w[i] = alone ? 0.0 : 0.5 * weights[face_edges[far]];
    };
    for_blocks(topology.face_count(), [&](int first, int count) {
        std::array<VectorRows, 3> corners;
        Covariances sums{};
        for (int i = 0; i < count; ++i)
            for (int c = 0; c < 3; ++c)
                corners[to_size(c)].set(i, position(topology.faces()(first + i, c)));
        for (std::size_t c = 0; c < 3; ++c) {
            Side side;
            for (int i = 0; i < count; ++i)
                gather_side(i, first + i, static_cast<int>(c), side);
            add_side(count, side, corners[c], corners[(c + 1) % 3], sums);
        }
        QuaternionRows turned;
        Row found;
        for (int i = 0; i < count; ++i)
            turned.set(i, frames[to_size(first + i)]);
        turn_frames(count, sums, turned, found);
        for (int i = 0; i < count; ++i) {
            Quaterniond& frame = frames[to_size(first + i)];
            if (found[i] == 1.0)
                frame = turned.get(i);
            else
                frame = nearest_rotation_from(sums.get(i), frame.toRotationMatrix());
        }
    });
    return frames;
}

} // namespace shape::internal
