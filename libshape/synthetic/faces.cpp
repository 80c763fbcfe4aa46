// SPDX-License-Identifier: MIT

#include <Eigen/Core>
#include <array>
#include <cmath>
#include <numbers>

#include "libshape/base/format.h"
#include "libshape/base/random.h"
#include "libshape/synthetic/generators.h"
#include "libshape/synthetic/grids.h"
#include "libshape/synthetic/profiles.h"

// A face is a mask over the front of a head, life-size in millimetres: +x to its left, +y up, +z
// to the front, the origin of x and y midway between the eyes. Every vertex has a place (x, y) on
// the mean face seen from the front; features are bumps and grooves there, and people and moods
// move the places themselves, so that a vertex stays on its eyelid or lip.
namespace shape::synthetic {
namespace {

using Eigen::Vector2d;
using Eigen::Vector3d;
using std::numbers::pi;

constexpr double eye_x = 32.0;    ///< From the middle to the centre of an eye.
constexpr double mouth_x = 27.0;  ///< From the middle to a corner of the mouth.
constexpr double mouth_y = -74.0; ///< Where the lips meet.
constexpr double tip_y = -41.0;   ///< The tip of the nose.

/// How a person differs from the mean face; standard normal each.
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

// --- The bare head: an egg-shaped mask, polar angle up to `rim` from its front ------------------

constexpr double rim = 1.48; // [rad]
constexpr double half_width = 72.0;
constexpr double half_height = 104.0;
constexpr double centre_y = -14.0;

double taper(double up)
{
    return up < 0.0 ? 1.0 - 0.32 * up * up : 1.0 - 0.06 * up * up;
}

Vector3d bare_head(const Vector2d& on_disc)
{
    const double polar = rim * on_disc.norm();
    const Vector2d direction =
        on_disc.norm() > 0.0 ? Vector2d(on_disc.normalized()) : Vector2d::Zero();
    const double up = std::sin(polar) * direction.y();
    return {half_width * taper(up) * std::sin(polar) * direction.x(), centre_y + half_height * up,
            88.0 * std::pow(std::cos(polar), 0.65)};
}

/// Where the disc shows the place (x, y): the inverse of bare_head.
Vector2d on_disc(double x, double y)
{
    const double up = (y - centre_y) / half_height;
    const Vector2d sine(x / (half_width * taper(up)), up);
    return std::asin(sine.norm()) / rim * sine.normalized();
}

// --- Features at the place (x, y): what they add to the depth z [mm] ----------------------------

double brows(double x, double y, const Person& person)
{
    const double s = std::abs(x);
    const double extent = ramp(s, 8.0, 17.0) * (1.0 - ramp(s, 46.0, 58.0));
    const double arch = 17.5 + 5.5 * bump(s, 38.0, 15.0) - 3.0 * ramp(s, 42.0, 58.0);
    return extent * 2.4 * bump(y, arch, 3.0) +
           (3.5 + 1.0 * person.brow_ridge) * both(x, y, 26.0, 15.0, 15.0, 7.0);
}

double nose(double x, double y, const Person& person, const Mood& mood)
{
    const double ridge = std::pow(std::clamp((13.0 - y) / 53.0, 0.0, 1.0), 1.15);
    const double base = ramp(y, -55.0, -44.0);
    const double w = 6.5 + 3.5 * ramp(-y, 8.0, 42.0);
    double z = 22.0 * ridge * base * bump(x, 0.0, w);
    z += 4.0 * spot(x, y, 0.0, tip_y, 7.0, 6.0);
    z += (1.8 * person.bridge) * spot(x, y, 0.0, -6.0, 6.0, 14.0);
    z += 8.0 * both(x, y, 13.0, -46.0, 4.6, 5.0);                     // wings
    z -= 2.2 * both(x, y, 20.5, -46.0, 2.2, 6.0);                     // crease beside them
    z -= 1.5 * both(x, y, 8.5, -40.0, 2.2, 4.0);                      // crease above them
    z -= (6.5 + 2.0 * mood.angry) * both(x, y, 6.8, -51.5, 3.2, 2.3); // nostrils
    z -= 3.0 * both(x, y, 14.0, 4.0, 5.0, 8.0);                       // beside the bridge
    return z;
}

double mouth(double x, double y, const Person& person, const Mood& mood)
{
    const double s = std::abs(x);
    const double from_line = y - mouth_y - 0.8 * (bump(x, 7.0, 4.0) + bump(x, -7.0, 4.0));
    const double full =
        (1.0 + 0.2 * person.lips) * (1.0 - 0.2 * mood.happy) * (1.0 - 0.4 * mood.angry);
    const double upper = 1.0 - ramp(s, 6.0, mouth_x);
    const double lower = 1.0 - ramp(s, 4.0, 24.0);
    double z = 6.0 * spot(x, y, 0.0, -72.0, 23.0, 17.0); // teeth behind
    z += 5.0 * full * upper * bump(from_line, 1.0 + 3.2 * upper, 2.7);
    z += 6.0 * full * lower * bump(from_line, -1.0 - 4.2 * lower, 3.6);
    z -= (3.2 + 1.2 * mood.happy) * (1.0 - ramp(s, 21.0, 29.0)) * bump(from_line, 0.0, 1.5);
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
    double z = -(0.7 + 2.6 * mood.happy + 1.0 * mood.angry) * fold;
    z += (4.0 + 1.2 * person.cheekbones) * both(x, y, 46.0, -14.0, 13.0, 10.0);
    z += (-3.0 + 2.0 * person.cheeks) * both(x, y, 43.0, -58.0, 13.0, 16.0);
    z += (9.0 + 1.8 * person.chin + 1.5 * mood.angry) * spot(x, y, 0.0, -104.0, 14.0, 9.0);
    z += (2.5 + 2.0 * person.forehead) * spot(x, y, 0.0, 55.0, 42.0, 22.0);
    z -= 3.0 * both(x, y, 64.0, 35.0, 10.0, 18.0);           // temples
    z -= 2.4 * mood.angry * both(x, y, 4.5, 22.0, 1.8, 8.0); // frown
    z += 5.5 * mood.happy * both(x, y, 38.0, -32.0, 13.0, 11.0);
    z += 1.5 * mood.happy * both(x, y, eye_x, -10.0, 11.0, 3.0);
    return z;
}

/// Puts the eye into its socket: skin is the depth so far.
double with_eye(double x, double y, double skin)
{
    const double socket = 88.0 * 0.92;
    const double s = std::abs(x) - eye_x;
    const double u = s / 15.0; // -1 inner, 1 outer corner
    const double level = y - 1.0 * u;
    const double upper_lid = 5.6 * (1.0 - u * u);
    const double lower_lid = -3.9 * (1.0 - u * u);
    const double open = ramp(std::min(upper_lid - level, level - lower_lid), -0.9, 0.9);
    const double off_axis = (s * s + y * y) / 2.0;
    const double ball_radius = 12.5;
    const double lid_radius = 14.5;
    const double centre = socket - 17.0;
    const double iris = std::sqrt(2.0 * off_axis);
    double ball = centre + ball_radius - off_axis / ball_radius;
    ball -= 1.3 * (1.0 - ramp(iris, 1.6, 3.6)); // pupil
    const double lid = centre + lid_radius - off_axis / lid_radius;
    const double crease = 1.4 * bump(level, upper_lid + 4.0, 1.3) * bump(u, 0.0, 0.6);
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
    d.x() += 1.7 * p.nose_width * apart(x, y, 12.0, -46.0, 8.0, 9.0);
    d += Vector3d(0.0, 1.2, 2.0) * p.nose_tip * spot(x, y, 0.0, tip_y, 9.0, 9.0);
    d.x() += 2.2 * p.mouth_width * apart(x, y, mouth_x, mouth_y, 11.0, 10.0);
    d.y() -= 1.7 * p.upper_lip * spot(x, y, 0.0, mouth_y, 30.0, 12.0);
    return d;
}

Vector3d shift_of_mood(double x, double y, const Mood& mood)
{
    Vector3d smile = Vector3d::Zero();
    const double corner = both(x, y, mouth_x, mouth_y, 11.0, 11.0);
    smile += Vector3d(0.0, 9.0, -4.0) * corner;
    smile.x() += 8.0 * apart(x, y, mouth_x, mouth_y, 12.0, 11.0);
    smile.y() -= 1.5 * spot(x, y, 0.0, mouth_y, 10.0, 9.0);
    smile.y() += 4.5 * both(x, y, 40.0, -34.0, 14.0, 11.0);
    smile.y() += 2.3 * both(x, y, eye_x, -5.0, 10.0, 4.0);
    smile.y() += 1.0 * both(x, y, 32.0, 20.0, 18.0, 7.0);
    smile.x() += 1.6 * apart(x, y, 13.0, -46.0, 6.0, 6.0);

    Vector3d scowl = Vector3d::Zero();
    scowl += Vector3d(0.0, -7.5, 2.5) * both(x, y, 16.0, 18.0, 11.0, 8.0);
    scowl.x() -= 3.5 * apart(x, y, 18.0, 18.0, 10.0, 8.0);
    scowl.y() += 3.0 * both(x, y, 47.0, 20.0, 10.0, 9.0);
    scowl.y() -= 2.6 * both(x, y, 27.0, 6.0, 9.0, 3.5);
    scowl.y() += 0.8 * both(x, y, eye_x, -4.5, 10.0, 3.5);
    scowl += Vector3d(0.0, -5.0, -1.0) * both(x, y, mouth_x, mouth_y, 10.0, 9.0);
    scowl.x() -= 2.5 * apart(x, y, mouth_x, mouth_y, 11.0, 10.0);
    scowl.y() -= 1.4 * spot(x, y, 0.0, mouth_y + 5.0, 18.0, 3.5);
    scowl.y() += 1.6 * spot(x, y, 0.0, mouth_y - 5.5, 18.0, 3.5);
    scowl.y() += 2.0 * spot(x, y, 0.0, -102.0, 18.0, 9.0);
    scowl += Vector3d(0.0, 1.5, 1.0) * both(x, y, 13.0, -46.0, 6.0, 6.0);
    scowl.x() += 2.4 * apart(x, y, 13.0, -46.0, 6.0, 6.0);
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

/// Draws the grid together around eyes, nose and mouth: there triangles are less than half as long.
Vector2d gathered(const Vector2d& point)
{
    struct Centre
    {
        Vector2d place;
        double strength, width;
    };
    static const std::array<Centre, 6> centres{{{on_disc(eye_x, 2.0), 0.5, 0.13},
                                                {on_disc(-eye_x, 2.0), 0.5, 0.13},
                                                {on_disc(0.0, -46.0), 0.42, 0.11},
                                                {on_disc(0.0, mouth_y), 0.42, 0.10},
                                                {on_disc(20.0, mouth_y), 0.36, 0.10},
                                                {on_disc(-20.0, mouth_y), 0.36, 0.10}}};
    Vector2d moved = point;
    for (const Centre& centre : centres) {
        const Vector2d away = point - centre.place;
        moved -= centre.strength * bump(away.norm(), 0.0, centre.width) * away;
    }
    return moved;
}

/// Lattice positions on the unit disc: straight rows in the middle, circles at the rim.
Vector2d disc_position(const DiscVertex& v, int rings)
{
    if (v.ring == 0)
        return Vector2d::Zero();
    const double share = static_cast<double>(v.index % v.ring) / v.ring;
    const double corner = pi / 3.0 * (v.index / v.ring);
    const Vector2d from(std::cos(corner), std::sin(corner));
    const Vector2d to(std::cos(corner + pi / 3.0), std::sin(corner + pi / 3.0));
    const double radius = static_cast<double>(v.ring) / rings;
    const Vector2d hexagon = radius * ((1.0 - share) * from + share * to);
    const Vector2d circle = radius * Vector2d(std::cos(v.angle()), std::sin(v.angle()));
    const double round = ramp(radius, 0.2, 1.0);
    return (1.0 - round) * hexagon + round * circle;
}

Person random_person(Random& random)
{
    const auto trait = [&] { return std::clamp(random.normal(), -2.2, 2.2); };
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

} // namespace

Collection make_faces(const SyntheticOptions& options)
{
    // A disc of m rings has 1 + 3 m (m + 1) vertices.
    const int rings =
        static_cast<int>(std::lround(std::sqrt((options.vertices - 0.25) / 3.0) - 0.5));
    const Disc grid = disc(rings);
    std::vector<Vector3d> bare;
    for (const DiscVertex& v : grid.vertices)
        bare.push_back(bare_head(gathered(disc_position(v, rings))));

    Members members(grid.faces, {"subject", "expression"});
    Random seeds(options.seed);
    for (int i = 0; i < options.count; ++i) {
        Random random(seeds.bits());
        const Person person = random_person(random);
        const Mood happy{.happy = random.uniform(0.7, 1.2)};
        const Mood angry{.angry = random.uniform(0.7, 1.2)};
        const std::string subject = join("s", padded(i, 3));
        const auto add = [&](const char* expression, const Mood& mood) {
            Points points(static_cast<Eigen::Index>(bare.size()), 3);
            for (std::size_t v = 0; v < bare.size(); ++v)
                points.row(static_cast<Eigen::Index>(v)) =
                    face_point(bare[v], person, mood).transpose();
            members.add(join(subject, "_", expression), std::move(points), {subject, expression});
        };
        add("neutral", {});
        add("happy", happy);
        add("angry", angry);
    }
    return members.take();
}

} // namespace shape::synthetic
