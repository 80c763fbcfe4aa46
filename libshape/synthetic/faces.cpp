// SPDX-License-Identifier: MIT

#include <Eigen/Core>
#include <array>
#include <cmath>
#include <functional>
#include <numbers>

#include "libshape/base/format.h"
#include "libshape/base/random.h"
#include "libshape/base/stop.h"
#include "libshape/synthetic/generators.h"
#include "libshape/synthetic/grids.h"
#include "libshape/synthetic/profiles.h"

// A face is a mask over the front of a head, life-size in millimetres: +x to its left, +y up, +z
// to the front, the origin of x and y midway between the eyes. Every vertex has a place (x, y) on
// the mean face seen from the front; features are bumps and grooves there, and people and moods
// move the places themselves, so that a vertex stays on its eyelid or lip.
namespace shape::internal::synthetic {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using std::numbers::pi;

constexpr double eye_x = 32.0;    ///< From the middle to the centre of an eye.
constexpr double mouth_x = 27.0;  ///< From the middle to a corner of the mouth.
constexpr double mouth_y = -74.0; ///< Where the lips meet.
constexpr double tip_y = -41.0;   ///< The tip of the nose.

/// How a person differs from the mean face; 0 on average, mostly within -2 and 2.
struct Person
{
    double size, width, height, depth, forehead, brow_ridge, brow_height, eye_distance, eye_size,
        eye_slant, nose_length, nose_width, bridge, nose_tip, cheekbones, cheeks, mouth_width, lips,
        upper_lip, jaw, chin;
};

struct Mood
{
    double happy = 0.0; ///< 0 neutral, 1 a broad smile.
    double angry = 0.0; ///< 0 neutral, 1 a scowl.
};

double spot(double x, double y, double cx, double cy, double wx, double wy)
{
    return bump(x, cx, wx) * bump(y, cy, wy);
}

/// A spot on both sides, of equal and of opposite sign.
double both(double x, double y, double cx, double cy, double wx, double wy)
{
    return (bump(x, cx, wx) + bump(x, -cx, wx)) * bump(y, cy, wy);
}
double apart(double x, double y, double cx, double cy, double wx, double wy)
{
    return (bump(x, cx, wx) - bump(x, -cx, wx)) * bump(y, cy, wy);
}

// --- Lines that rows of the grid follow: heights y over x ---------------------------------------

double beyond(double x, double from)
{
    return std::pow(std::max(std::abs(x) - from, 0.0), 2);
}

double jaw_line(double x)
{
    return -119.0 + 0.0115 * x * x;
}
double lip_line(double x)
{
    return mouth_y + 0.9 * (bump(x, 7.0, 4.0) + bump(x, -7.0, 4.0)) + 0.0165 * beyond(x, 27.0);
}
double nose_base(double x)
{
    return -55.0 + 0.0058 * x * x;
}
double hair_line(double x)
{
    return 38.0 + 52.0 * std::sqrt(1.0 - std::pow(x / 74.0, 2));
}

/// Across an eye: -1 at the inner corner, 1 at the outer one.
double eye_u(double x)
{
    return (std::abs(x) - eye_x) / 15.0;
}

/// An almond over the eye, almost level lines beside it.
double almond(double x)
{
    return std::pow(std::max(1.0 - std::pow(eye_u(x), 2), 0.0), 1.3);
}
double lid_middle(double x)
{
    return 2.0 * ramp(eye_u(x), -1.5, 1.5) - 1.0;
}
double lid_gap(double x)
{
    return 1.0 + 1.5 * ramp(-eye_u(x), 0.9, 2.1) + 3.0 * ramp(eye_u(x), 0.9, 2.4);
}
double lower_lid(double x)
{
    return lid_middle(x) - lid_gap(x) - 3.6 * almond(x);
}
double upper_lid(double x)
{
    return lid_middle(x) + lid_gap(x) + 5.0 * almond(x);
}

// --- The bare head: round across, `rim` to either side of the front -----------------------------

constexpr double rim = 1.38; // [rad]

double half_width(double y)
{
    const double above = std::max(y - 25.0, 0.0) / 60.0;
    const double below = std::max(-20.0 - y, 0.0) / 50.0;
    return 71.0 - 12.0 * above * above - 9.0 * below * below;
}

double profile(double y)
{
    const double above = std::max(y - 5.0, 0.0);
    return 88.0 - 0.0036 * above * above - 12.0 * ramp(-y, 92.0, 124.0);
}

/// The point on the line y(x) at an angle around the head.
Vector3d bare_head(double angle, const std::function<double(double)>& line)
{
    double x = 71.0 * std::sin(angle);
    for (int i = 0; i < 20; ++i) // a contraction: lines and half widths are flat
        x = half_width(line(x)) * std::sin(angle);
    return {x, line(x), profile(line(x)) * std::pow(std::cos(angle), 0.75)};
}

// --- Features at the place (x, y): what they add to the depth z [mm] ----------------------------

double brows(double x, double y, const Person& person)
{
    const double s = std::abs(x);
    const double extent = ramp(s, 5.0, 20.0) * (1.0 - ramp(s, 46.0, 60.0));
    const double arch = 17.5 + 5.5 * bump(s, 38.0, 15.0) - 3.0 * ramp(s, 42.0, 58.0);
    return extent * 2.6 * bump(y, arch, 3.4) +
           (3.5 + 1.0 * person.brow_ridge) * both(x, y, 26.0, 15.0, 15.0, 7.0);
}

double nose(double x, double y, const Person& person, const Mood& mood)
{
    const double ridge = std::pow(std::clamp((13.0 - y) / 53.0, 0.0, 1.0), 1.2);
    const double bottom = ramp(y, -57.0 + 0.035 * x * x, -44.0 + 0.035 * x * x);
    const double w = 6.2 + 2.6 * ramp(-y, 8.0, 42.0);
    double z = 20.0 * ridge * bottom * bump(x, 0.0, w);
    z += 4.5 * spot(x, y, 0.0, tip_y - 1.0, 6.5, 6.0);
    z += (1.8 * person.bridge) * spot(x, y, 0.0, -6.0, 6.0, 14.0);
    z += 7.0 * both(x, y, 12.5, -45.0, 4.6, 4.4);                     // wings
    z -= 2.0 * both(x, y, 20.0, -46.0, 2.4, 5.5);                     // crease beside them
    z -= 1.4 * both(x, y, 8.0, -40.5, 2.2, 3.5);                      // crease above them
    z -= (5.0 + 2.0 * mood.angry) * both(x, y, 6.5, -50.0, 3.0, 2.4); // nostrils
    z -= 3.0 * both(x, y, 14.0, 4.0, 5.0, 8.0);                       // beside the bridge
    return z;
}

double mouth(double x, double y, const Person& person, const Mood& mood)
{
    const double s = std::abs(x);
    const double from_line = y - lip_line(x);
    const double full =
        (1.0 + 0.2 * person.lips) * (1.0 - 0.2 * mood.happy) * (1.0 - 0.4 * mood.angry);
    const double upper = 1.0 - ramp(s, 10.0, 28.0);
    const double lower = 1.0 - ramp(s, 8.0, 26.0);
    double z = 6.0 * spot(x, y, 0.0, -72.0, 23.0, 17.0); // teeth behind
    z += 5.0 * full * upper * bump(from_line, 1.0 + 3.0 * upper, 2.5);
    z += 6.6 * full * lower * bump(from_line, -1.0 - 3.8 * lower, 3.3);
    z -= (3.2 + 1.2 * mood.happy) * (1.0 - ramp(s, 21.0, 29.0)) * bump(from_line, 0.0, 1.7);
    z -= 2.4 * both(x, y, mouth_x + 2.0, mouth_y, 3.6, 3.6);
    z -= 1.6 * spot(x, y, 0.0, -60.0, 2.6, 5.0); // philtrum
    z += 0.9 * both(x, y, 4.6, -61.0, 1.9, 5.0);
    z -= (4.0 + 1.5 * mood.angry) * spot(x, y, 0.0, -91.0, 14.0, 4.0);
    return z;
}

/// Cheeks, chin, forehead, and the fold from the nose to the corner of the mouth.
double flesh(double x, double y, const Person& person, const Mood& mood)
{
    const double s = std::abs(x);
    const Vector2d along = Vector2d(14.0, -28.0).normalized();
    const Vector2d from_middle(s - 27.0, y + 62.0);
    const double across = along.x() * from_middle.y() - along.y() * from_middle.x();
    const double fold = bump(across, 0.0, 2.6) * bump(along.dot(from_middle), 0.0, 11.0);
    double z = -(0.6 + 1.7 * mood.happy + 0.8 * mood.angry) * fold;
    z += (4.0 + 1.2 * person.cheekbones) * both(x, y, 46.0, -14.0, 13.0, 10.0);
    z += (-3.0 + 2.0 * person.cheeks) * both(x, y, 43.0, -58.0, 13.0, 16.0);
    z += (9.0 + 1.8 * person.chin + 1.5 * mood.angry) * spot(x, y, 0.0, -104.0, 14.0, 9.0);
    z += (2.5 + 2.0 * person.forehead) * spot(x, y, 0.0, 55.0, 42.0, 22.0);
    z -= 3.0 * both(x, y, 64.0, 35.0, 10.0, 18.0);           // temples
    z -= 2.4 * mood.angry * both(x, y, 4.5, 19.0, 2.0, 5.5); // frown
    z += 5.5 * mood.happy * both(x, y, 38.0, -32.0, 13.0, 11.0);
    z += 1.5 * mood.happy * both(x, y, eye_x, -10.0, 11.0, 3.0);
    return z;
}

/// Puts the eye into its socket: skin is the depth so far.
double with_eye(double x, double y, double skin)
{
    const double u = eye_u(x);
    const double s = std::abs(x) - eye_x;
    const double inside = std::min(upper_lid(x) - y, y - lower_lid(x));
    const double open = ramp(inside, 0.0, 1.5) * ramp(1.0 - std::abs(u), 0.0, 0.15);
    const double off_axis = (0.7 * s * s + y * y) / 2.0;
    const double centre = 88.0 * 0.92 - 17.0;
    double ball = centre + 12.8 - off_axis / 12.5;
    ball -= 2.0 * (1.0 - ramp(std::hypot(s, y - 0.5), 1.5, 4.6)); // iris
    const double lid = centre + 14.7 - off_axis / 14.5;
    const double crease = 1.4 * bump(y, upper_lid(x) + 4.0, 1.4) * bump(u, 0.0, 0.6);
    const double covered = 0.5 * (skin + lid + std::hypot(skin - lid, 3.0)) - crease;
    return open * ball + (1.0 - open) * covered;
}

// --- Movements of the places themselves ---------------------------------------------------------

Vector3d shift_of_person(double x, double y, const Person& p)
{
    const double down = ramp(-y, 0.0, 115.0);
    Vector3d d = Vector3d::Zero();
    d.x() += 0.045 * p.width * x + 0.06 * p.jaw * x * ramp(-y, 20.0, 100.0);
    d.y() += -5.0 * p.height * down - 2.0 * p.chin * spot(x, y, 0.0, -108.0, 22.0, 14.0);
    d.x() += 1.7 * p.eye_distance * apart(x, y, eye_x, 2.0, 16.0, 16.0);
    const double near_eye = both(x, y, eye_x, 0.0, 12.0, 10.0);
    const double from_eye = std::abs(x) - eye_x;
    d.x() += 0.07 * p.eye_size * near_eye * std::copysign(from_eye, x * from_eye);
    d.y() += 0.10 * p.eye_size * near_eye * y + 0.07 * p.eye_slant * near_eye * from_eye;
    d.y() += 1.6 * p.brow_height * both(x, y, 30.0, 19.0, 18.0, 7.0);
    d.y() -= 2.6 * p.nose_length * spot(x, y, 0.0, -45.0, 16.0, 13.0);
    d.x() += 1.2 * p.nose_width * apart(x, y, 12.0, -46.0, 8.0, 9.0);
    d += Vector3d(0.0, 1.2, 2.0) * p.nose_tip * spot(x, y, 0.0, tip_y, 9.0, 9.0);
    d.x() += 2.2 * p.mouth_width * apart(x, y, mouth_x, mouth_y, 11.0, 10.0);
    d.y() -= 1.7 * p.upper_lip * spot(x, y, 0.0, mouth_y, 30.0, 12.0);
    return d;
}

Vector3d shift_of_mood(double x, double y, const Mood& mood)
{
    Vector3d smile = Vector3d::Zero();
    smile += Vector3d(0.0, 8.5, -4.0) * both(x, y, mouth_x, mouth_y, 13.0, 13.0);
    smile.x() += 7.5 * apart(x, y, mouth_x, mouth_y, 14.0, 13.0);
    smile.y() -= 1.5 * spot(x, y, 0.0, mouth_y, 10.0, 10.0);
    smile.y() += 4.0 * both(x, y, 40.0, -34.0, 15.0, 13.0);
    smile.y() += 2.0 * both(x, y, eye_x, -6.0, 11.0, 5.0);
    smile.y() += 1.0 * both(x, y, 32.0, 20.0, 18.0, 8.0);
    smile.x() += 1.6 * apart(x, y, 13.0, -46.0, 7.0, 7.0);

    Vector3d scowl = Vector3d::Zero();
    scowl += Vector3d(0.0, -7.0, 2.5) * both(x, y, 16.0, 19.0, 12.0, 11.0);
    scowl.x() -= 3.0 * apart(x, y, 18.0, 18.0, 11.0, 9.0);
    scowl.y() += 3.0 * both(x, y, 48.0, 20.0, 11.0, 10.0);
    scowl.y() -= 1.4 * both(x, y, 28.0, 6.0, 10.0, 4.5);
    scowl.y() += 0.6 * both(x, y, eye_x, -5.0, 10.0, 4.5);
    scowl += Vector3d(0.0, -5.0, -1.0) * both(x, y, mouth_x, mouth_y, 12.0, 12.0);
    scowl.x() -= 2.0 * apart(x, y, mouth_x, mouth_y, 13.0, 12.0);
    scowl.y() += 1.5 * spot(x, y, 0.0, mouth_y, 14.0, 9.0);
    scowl.y() += 1.0 * spot(x, y, 0.0, -102.0, 20.0, 12.0);
    scowl += Vector3d(0.0, 1.2, 1.0) * both(x, y, 13.0, -46.0, 7.0, 7.0);
    scowl.x() += 2.2 * apart(x, y, 13.0, -46.0, 7.0, 7.0);
    return mood.happy * smile + mood.angry * scowl;
}

Vector3d face_point(const Vector3d& bare, const Person& person, const Mood& mood)
{
    const double x = bare.x();
    const double y = bare.y();
    double z = bare.z() - 10.0 * both(x, y, eye_x, 1.0, 17.0, 11.0);
    z += brows(x, y, person) + nose(x, y, person, mood) + mouth(x, y, person, mood) +
         flesh(x, y, person, mood);
    Vector3d p(x, y, with_eye(x, y, z));
    p += shift_of_person(x, y, person) + shift_of_mood(x, y, mood);
    p.z() *= 1.0 + 0.04 * person.depth;
    return (1.0 + 0.03 * person.size) * p;
}

// --- The grid -----------------------------------------------------------------------------------

/// Rows between two lines. `lean` in (-1, 1) makes the spacing grow (> 0) or shrink upwards;
/// `waist` in (-1, 1) makes it larger (> 0) or smaller in the middle.
struct Band
{
    double (*below)(double);
    double (*above)(double);
    double rows; ///< Share of the rows.
    double lean;
    double waist;
};

constexpr std::array<Band, 5> bands{{{jaw_line, lip_line, 12.0, -0.5, 0.0},
                                     {lip_line, nose_base, 9.0, 0.0, 0.0},
                                     {nose_base, lower_lid, 15.0, 0.0, 0.35},
                                     {lower_lid, upper_lid, 5.0, 0.0, 0.0},
                                     {upper_lid, hair_line, 19.0, 0.65, 0.0}}};

/// A net of triangles: odd rows are half a column ahead and have one vertex more. Rows run along
/// eyelids and lips, so that creases are drawn clean however coarse the net is.
struct Net
{
    Faces faces;
    std::vector<Vector3d> bare; ///< Positions on the bare head.
    std::vector<int> rim;       ///< Counter-clockwise seen from the front.
};

/// Vertices around a net: its first row, the right ends of the rows, the last row, the left ends.
std::vector<int> rim_of(const std::vector<std::vector<int>>& rows)
{
    std::vector<int> loop(rows.front().begin(), rows.front().end());
    for (std::size_t r = 1; r + 1 < rows.size(); ++r)
        loop.push_back(rows[r].back());
    loop.insert(loop.end(), rows.back().rbegin(), rows.back().rend());
    for (std::size_t r = rows.size() - 2; r > 0; --r)
        loop.push_back(rows[r].front());
    return loop;
}

Net net(int vertices)
{
    double shares = 0.0;
    for (const Band& band : bands)
        shares += band.rows;
    const double rows = std::sqrt(1.25 * vertices);
    const int columns = std::max(8, static_cast<int>(std::lround(vertices / rows)));

    Net result;
    std::vector<std::vector<int>> numbers; // of the vertices, row by row
    const auto add_row = [&](const std::function<double(double)>& line) {
        throw_if_stop_requested();
        const bool odd = numbers.size() % 2 == 1;
        std::vector<int>& row = numbers.emplace_back();
        for (int c = 0; c < columns + (odd ? 1 : 0); ++c) {
            const double place = std::clamp(odd ? c - 0.5 : 1.0 * c, 0.0, columns - 1.0);
            const double t = 2.0 * place / (columns - 1) - 1.0;
            row.push_back(static_cast<int>(result.bare.size()));
            result.bare.push_back(bare_head(rim * (0.6 + 0.4 * t * t) * t, line));
        }
    };
    add_row(jaw_line);
    for (const Band& band : bands) {
        const int count = std::max(1, static_cast<int>(std::lround(rows * band.rows / shares)));
        for (int i = 1; i <= count; ++i) {
            const double t = static_cast<double>(i) / count;
            const double share =
                t - band.lean * t * (1.0 - t) - band.waist * std::sin(2.0 * pi * t) / (2.0 * pi);
            add_row(
                [&](double x) { return (1.0 - share) * band.below(x) + share * band.above(x); });
        }
    }
    std::vector<std::array<int, 3>> faces;
    for (std::size_t r = 0; r + 1 < numbers.size(); ++r) {
        const bool odd = r % 2 == 1;
        const std::vector<int>& shorter = numbers[odd ? r + 1 : r];
        const std::vector<int>& longer = numbers[odd ? r : r + 1];
        const auto add = [&](int a, int b, int c) {
            faces.push_back(odd ? std::array{a, c, b} : std::array{a, b, c});
        };
        for (std::size_t c = 0; c < shorter.size(); ++c) {
            add(shorter[c], longer[c + 1], longer[c]);
            if (c + 1 < shorter.size())
                add(shorter[c], shorter[c + 1], longer[c + 1]);
        }
    }
    result.faces = to_faces(faces);
    result.rim = rim_of(numbers);
    return result;
}

Person random_person(Random& random)
{
    const auto trait = [&] { return 1.4 * std::clamp(random.normal(), -2.0, 2.0); };
    Person person{};
    for (double* value :
         {&person.size,        &person.width,      &person.height,      &person.depth,
          &person.forehead,    &person.brow_ridge, &person.brow_height, &person.eye_distance,
          &person.eye_size,    &person.eye_slant,  &person.nose_length, &person.nose_width,
          &person.bridge,      &person.nose_tip,   &person.cheekbones,  &person.cheeks,
          &person.mouth_width, &person.lips,       &person.upper_lip,   &person.jaw,
          &person.chin})
        *value = trait();
    return person;
}

// --- The back of the head: rings that shrink from the rim of the mask to a pole -----------------

constexpr double back_depth = 105.0; ///< From the middle of the rim to the pole [mm].

struct BackVertex
{
    double polar = 0.0;  ///< 0 at the rim, pi/2 at the pole.
    double around = 0.0; ///< Share of the rim, [0, 1).
};

struct Back
{
    std::vector<std::array<int, 3>> faces; ///< Its vertices are numbered after those of the mask.
    std::vector<BackVertex> vertices;
};

Back back_of(const Net& mask)
{
    const auto rim_size = static_cast<double>(mask.rim.size());
    const int rings = std::max(4, static_cast<int>(std::lround(0.16 * rim_size)));
    const auto first = static_cast<int>(mask.bare.size());
    Back back;
    std::vector<int> outer = mask.rim;
    for (int ring = 1; ring < rings; ++ring) {
        const double share = static_cast<double>(ring) / rings;
        const double coarser = 1.0 - 0.4 * ramp(share, 0.0, 0.4);
        const int count = std::max(
            6, static_cast<int>(std::lround(rim_size * coarser * std::cos(0.5 * pi * share))));
        std::vector<int> inner;
        for (int i = 0; i < count; ++i) {
            inner.push_back(first + static_cast<int>(back.vertices.size()));
            back.vertices.push_back({0.5 * pi * share, static_cast<double>(i) / count});
        }
        // A strip of triangles; the ring that lags behind moves on.
        for (std::size_t i = 0, j = 0; i < outer.size() || j < inner.size();) {
            const auto at = [](const std::vector<int>& r, std::size_t k) {
                return r[k % r.size()];
            };
            const bool on_outer =
                j == inner.size() ||
                (i < outer.size() && (i + 1) * inner.size() <= (j + 1) * outer.size());
            if (on_outer)
                back.faces.push_back({at(outer, i + 1), at(outer, i), at(inner, j)});
            else
                back.faces.push_back({at(outer, i), at(inner, j), at(inner, j + 1)});
            ++(on_outer ? i : j);
        }
        outer = std::move(inner);
    }
    const int pole = first + static_cast<int>(back.vertices.size());
    back.vertices.push_back({0.5 * pi, 0.0});
    for (std::size_t i = 0; i < outer.size(); ++i)
        back.faces.push_back({outer[(i + 1) % outer.size()], outer[i], pole});
    return back;
}

/// Adds the back to the points of a mask: it leaves the rim straight backwards.
void add_back(const Back& back, const std::vector<int>& loop, double size, Points& points)
{
    Eigen::RowVector3d centre = Eigen::RowVector3d::Zero();
    for (const int v : loop)
        centre += points.row(v) / static_cast<double>(loop.size());
    const Eigen::Index mask_size = points.rows();
    points.conservativeResize(mask_size + static_cast<Eigen::Index>(back.vertices.size()), 3);
    for (std::size_t i = 0; i < back.vertices.size(); ++i) {
        const BackVertex& v = back.vertices[i];
        const double place = v.around * static_cast<double>(loop.size());
        const auto before = static_cast<std::size_t>(place);
        const double share = place - std::floor(place);
        const Eigen::RowVector3d on_rim = (1.0 - share) * points.row(loop[before]) +
                                          share * points.row(loop[(before + 1) % loop.size()]);
        points.row(mask_size + static_cast<Eigen::Index>(i)) =
            centre + std::cos(v.polar) * (on_rim - centre) -
            size * back_depth * std::sin(v.polar) * Eigen::RowVector3d::UnitZ();
    }
}

/// People, each neutral, happy and angry.
/// @param back  Added to the masks if it has vertices.
Collection make_people(const SyntheticOptions& options, const Net& mask, const Back& back)
{
    Faces faces(mask.faces.rows() + static_cast<Eigen::Index>(back.faces.size()), 3);
    faces << mask.faces, to_faces(back.faces);
    Members members(std::move(faces), {"subject", "expression"});
    Random seeds(options.seed);
    for (int i = 0; i < options.count; ++i) {
        Random random(seeds.bits());
        const Person person = random_person(random);
        const Mood happy{.happy = random.uniform(0.5, 1.2)};
        const Mood angry{.angry = random.uniform(0.5, 1.2)};
        const std::string subject = join("s", padded(i, 3));
        const auto add = [&](const char* expression, const Mood& mood) {
            Points points(static_cast<Eigen::Index>(mask.bare.size()), 3);
            for (std::size_t v = 0; v < mask.bare.size(); ++v) {
                throw_if_stop_requested();
                points.row(static_cast<Eigen::Index>(v)) =
                    face_point(mask.bare[v], person, mood).transpose();
            }
            add_back(back, mask.rim, 1.0 + 0.03 * person.size, points);
            members.add(join(subject, "_", expression), std::move(points), {subject, expression});
        };
        add("neutral", {});
        add("happy", happy);
        add("angry", angry);
    }
    return members.take();
}

} // namespace

Collection make_faces(const SyntheticOptions& options)
{
    return make_people(options, net(options.vertices), {});
}

Collection make_heads(const SyntheticOptions& options)
{
    Net mask;
    Back back;
    double share = 0.45; // of the mask; the rest follows from its rim
    for (int attempt = 0; attempt < 3; ++attempt) {
        mask = net(static_cast<int>(std::lround(share * options.vertices)));
        back = back_of(mask);
        share *= static_cast<double>(options.vertices) /
                 static_cast<double>(mask.bare.size() + back.vertices.size());
    }
    return make_people(options, mask, back);
}

} // namespace shape::internal::synthetic
