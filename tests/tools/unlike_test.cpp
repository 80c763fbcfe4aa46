// SPDX-License-Identifier: MIT

#include <filesystem>

#include "libshape/base/format.h"
#include "libshape/io/mesh_file.h"
#include "tests/support/meshes.h"
#include "tests/support/seams.h"
#include "tests/tools/program_test.h"

namespace shape::test {
using namespace internal;
namespace {

/// Six spheres in set/, of which models and differences are made, of unit scale and as they are, and the same of their mirror
/// images and in another unit; and meshes that do not go with them.
class Unlike : public ProgramTest
{
protected:
    Unlike()
    {
        static const MadeOnce made(fill);
        made.copy_into(folder_);
    }

    static void fill(const Folder& folder)
    {
        std::string labels = "mesh,pair,ex\n";
        for (unsigned i = 0; i < 6; ++i) {
            const TestMesh mesh = bumpy_sphere(1, 0.2, i + 1);
            const std::string name = join("s", i);
            for (const char* set : {"set", "mirrors", "larger"})
                folder.write(join(set, "/.keep"), "");
            const Faces& faces = mesh.topology.faces();
            write_mesh(folder / join("set/", name, ".ply"), mesh.points, faces);
            write_mesh(folder / join("mirrors/", name, ".ply"), mirror_image(mesh.points), faces);
            write_mesh(folder / join("larger/", name, ".ply"), 10.0 * mesh.points, faces);
            labels += join(name, ",", i / 2, ",", i % 2 == 0 ? "a" : "b", "\n");
        }
        folder.write("labels.csv", labels);
        const TestMesh other = bumpy_sphere(1, 0.2, 9);
        const Faces& faces = other.topology.faces();
        write_mesh(folder / "sound.ply", other.points, faces);
        write_mesh(folder / "mirror.ply", mirror_image(other.points), faces);
        write_mesh(folder / "large.ply", 10.0 * other.points, faces);
        write_mesh(folder / "small.ply", 0.1 * other.points, faces);
        write_mesh(folder / "reversed.ply", other.points, reversed_faces(faces));
        write_mesh(folder / "both.ply", mirror_image(other.points), reversed_faces(faces));
        for (const Arguments& arguments :
             {Arguments{"stats", "set", "-o", "unit.h5"},
              Arguments{"stats", "set", "-o", "none.h5", "--scale", "none"},
              difference_of("set", "d.h5", "unit"), difference_of("set", "dn.h5", "none"),
              difference_of("mirrors", "dm.h5", "unit"), difference_of("larger", "dl.h5", "none")})
            run_or_throw(folder, arguments);
    }

    static Arguments difference_of(const std::string& set, const std::string& output,
                                   const std::string& scale)
    {
        return {"difference", set,    "--labels", "labels.csv", "--pair-by", "pair", "--from",
                "ex=a",       "--to", "ex=b",     "--scale",    scale,       "-o",   output};
    }

    /// What is said on the way by a run that succeeds.
    [[nodiscard]] std::string said_by(const Arguments& arguments) const
    {
        std::filesystem::remove_all(folder_.path() / "out"); // of the run before
        const Outcome outcome = run_shape(folder_.path(), arguments + Arguments{"--force"});
        EXPECT_EQ(outcome.exit_code, 0) << testing::PrintToString(arguments) << "\n" << outcome.err;
        return outcome.err;
    }

    void expect_said(const Arguments& arguments, const Arguments& parts) const
    {
        const std::string said = said_by(arguments);
        for (const std::string& part : parts)
            EXPECT_NE(said.find(part), std::string::npos)
                << testing::PrintToString(arguments) << "\n'" << part << "' in: " << said;
        EXPECT_EQ(said.find("inside out"), std::string::npos) << said;
    }

    void expect_nothing_odd(const Arguments& arguments) const
    {
        const std::string said = said_by(arguments);
        for (const char* part : {"mirror", "inside out", "larger", "smaller"})
            EXPECT_EQ(said.find(part), std::string::npos)
                << testing::PrintToString(arguments) << "\n"
                << said;
    }

    /// With one line, which tells the cause.
    void expect_refused(const Arguments& arguments, const Arguments& parts) const
    {
        const Outcome outcome = run_shape(folder_.path(), arguments);
        const std::string line = testing::PrintToString(arguments);
        EXPECT_EQ(outcome.exit_code, 3) << line << "\n" << outcome.err;
        EXPECT_EQ(line_count(outcome.err), 1) << line << "\n" << outcome.err;
        for (const std::string& part : parts)
            EXPECT_NE(outcome.err.find(part), std::string::npos)
                << line << "\n'" << part << "' in: " << outcome.err;
    }

    /// Faces all turned, of a mesh and of a mirror image, whichever file comes first.
    void expect_turned_faces_told(const Arguments& before, const std::string& option,
                                  const Arguments& after) const
    {
        const auto with = [&](const Arguments& files) {
            Arguments arguments = before;
            if (!option.empty())
                arguments.push_back(option);
            return arguments + files + after;
        };
        expect_refused(with({"reversed.ply", "sound.ply"}),
                       {"reversed.ply: face 0 is ", "inside out: reverse its faces"});
        expect_refused(with({"sound.ply", "both.ply"}),
                       {"both.ply: face 0 is ", "mirror image: mirror it back"});
    }
};

const std::string back = " it back (one coordinate times -1, faces as they are)";
const std::string units = "; are they in millimetres and centimetres? ";

TEST_F(Unlike, MeshesAreNamedByProject)
{
    for (const char* model : {"unit.h5", "none.h5"})
        expect_said(
            {"project", model, "sound.ply", "mirror.ply", "large.ply", "small.ply", "-o", "s.csv"},
            {join("warning: mirror is a mirror image of the meshes of ", model,
                  "; edge lengths do not see that: mirror", back),
             "warning: large is ", join(" times larger than the meshes of ", model, units),
             "warning: small is ", join(" times smaller than the meshes of ", model, units)});
    expect_nothing_odd({"project", "unit.h5", "sound.ply", "set", "-o", "s.csv"});
    expect_turned_faces_told({"project", "unit.h5"}, "", {"-o", "x.csv"});
    (void)said_by({"stats", "set", "-o", "aligned.h5", "--space", "procrustes"});
    expect_said({"project", "aligned.h5", "mirror.ply", "-o", "s.csv"},
                {"aligned.h5; the space takes that for a difference of shape: mirror"});
}

TEST_F(Unlike, MeshesFarFromAllOthersAreNamedByProjectAndUpdate)
{
    const TestMesh other = bumpy_sphere(1, 0.2, 9);
    Points points = other.points;
    points.row(0) *= 8.0;
    write_mesh(folder_ / "astray.ply", points, other.topology.faces());
    for (const Arguments& command :
         {Arguments{"project", "unit.h5", "sound.ply", "astray.ply", "-o", "s.csv"},
          Arguments{"stats", "set", "astray.ply", "-o", "far.h5", "--update", "unit.h5"}})
        expect_said(
            command,
            {"warning: astray is ",
             " times as far from the mean as the farthest of the meshes of unit.h5 (exchanged "
             "vertices"});
    EXPECT_EQ(said_by({"project", "unit.h5", "sound.ply", "set", "-o", "s.csv"}).find("as far"),
              std::string::npos);
}

TEST_F(Unlike, MeshesAreNamedByRemove)
{
    const auto remove = [](const Arguments& meshes, const std::string& model) {
        return Arguments{"remove"} + meshes +
               Arguments{"--model", model, "--modes", "2", "-o", "out/"};
    };
    expect_said(remove({"mirror.ply", "sound.ply"}, "unit.h5"),
                {"warning: mirror is a mirror image of the meshes of unit.h5; angles change the "
                 "wrong way: mirror" +
                 back});
    expect_nothing_odd(remove({"large.ply", "sound.ply"}, "unit.h5")); // sizes are divided out
    expect_said(remove({"large.ply", "sound.ply"}, "none.h5"),
                {"warning: large is ", " times larger than the meshes of none.h5" + units,
                 "Sizes are part of the shape (--scale none)"});
    expect_turned_faces_told({"remove"}, "",
                             {"--model", "unit.h5", "--modes", "2", "-o", "refused/"});
    for (const char* direction : {"d.h5", "dn.h5"})
        expect_said({"remove", "mirror.ply", "--direction", direction, "-o", "x.ply"},
                    {join("mirror is a mirror image of the meshes of ", direction)});
    expect_said({"remove", "large.ply", "--direction", "dn.h5", "-o", "x.ply"},
                {"larger than the meshes of dn.h5"});
    expect_nothing_odd({"remove", "large.ply", "--direction", "d.h5", "-o", "x.ply"});
    expect_turned_faces_told({"remove"}, "", {"--direction", "d.h5", "-o", "refused/"});
}

TEST_F(Unlike, AMeshToBeLikeIsNamedByRemove)
{
    const Arguments remove{"remove", "set", "--modes", "2", "-o", "out/", "--like"};
    expect_said(remove + Arguments{"mirror.ply"},
                {"warning: --like: mirror is a mirror image of the meshes of the run; edge lengths "
                 "do not see that: mirror" +
                 back});
    expect_nothing_odd(remove + Arguments{"large.ply"});
    expect_said(remove + Arguments{"large.ply", "--scale", "none"},
                {"--like: large is ", "larger than the meshes of the run" + units});
    expect_said({"remove", "sound.ply", "--model", "none.h5", "--modes", "2", "-o", "x.ply",
                 "--like", "large.ply"},
                {"--like: large is ", "larger than the meshes of none.h5" + units});
    expect_refused(Arguments{"remove", "set", "--modes", "2", "-o", "x/", "--like", "both.ply"},
                   {"--like: another triangulation than the run; both.ply: face 0 is ",
                    "mirror image: mirror it back"});
}

TEST_F(Unlike, MeshesAreNamedByTransfer)
{
    const auto load = [](const std::string& file, const Arguments& onto) {
        return Arguments{"difference", "--load", file, "--mesh", "out/", "--onto"} + onto;
    };
    expect_said(load("d.h5", {"sound.ply", "mirror.ply"}),
                {"warning: --onto: mirror is a mirror image of the meshes of d.h5; angles change "
                 "the wrong way: mirror" +
                 back});
    expect_nothing_odd(load("d.h5", {"sound.ply", "large.ply"}));
    expect_said(load("dn.h5", {"sound.ply", "large.ply", "small.ply"}),
                {"warning: --onto: large is ", " times larger than the meshes of dn.h5" + units,
                 " times smaller than the meshes of dn.h5" + units,
                 "Lengths are added as they are (--scale none): bring all to one unit first"});
    expect_turned_faces_told({"difference", "--load", "d.h5", "--mesh", "refused/"}, "--onto", {});
    expect_said(difference_of("set", "again.h5", "none") +
                    Arguments{"--apply", "--mesh", "out/", "--onto", "s1", "large.ply"},
                {"--onto: large is ", "larger than the meshes of the difference" + units});
    expect_refused(difference_of("set", "x.h5", "unit") +
                       Arguments{"--apply", "--mesh", "x.ply", "--onto", "reversed.ply"},
                   {"--onto: another triangulation than the run; reversed.ply",
                    "inside out: reverse its faces"});
}

TEST_F(Unlike, DifferencesThatDoNotGoTogetherAreNamed)
{
    expect_said({"difference", "--load", "d.h5", "dm.h5", "--mesh", "sum.ply"},
                {"warning: --load: dm.h5 is of mirror images of the meshes of d.h5; angles change "
                 "the wrong way: make it anew of meshes mirrored back"});
    expect_said(
        {"difference", "--load", "dn.h5", "dl.h5", "--mesh", "sum.ply", "--amounts", "1,0.1"},
        {"warning: --load: dl.h5 is of meshes ", " times larger than the meshes of dn.h5"});
    expect_nothing_odd({"difference", "--load", "d.h5", "d.h5", "--mesh", "sum.ply"});
    if (!SHAPE_HAS_PAGE)
        return;
    expect_said(
        {"explore", "unit.h5", "-o", "p.html", "--difference", "d.h5", "--difference", "dm.h5",
         "--difference", "dl.h5"},
        {"warning: --difference: dm.h5 is of mirror images of the meshes of unit.h5",
         "warning: --difference: dl.h5 is of meshes ", "larger than the meshes of unit.h5"});
    expect_nothing_odd({"explore", "unit.h5", "-o", "p.html", "--difference", "d.h5"});
}

TEST_F(Unlike, MeshesThatAreAddedAreNamed)
{
    const Arguments added{"sound.ply", "mirror.ply", "large.ply"};
    expect_said(Arguments{"stats"} + added + Arguments{"-o", "u.h5", "--update", "unit.h5"},
                {"warning: mirror is a mirror image of the meshes of unit.h5", "warning: large is ",
                 "larger than the meshes of unit.h5" + units});
    expect_nothing_odd({"stats", "set", "sound.ply", "-o", "u.h5", "--update", "unit.h5"});
    expect_turned_faces_told({"stats"}, "", {"-o", "x.h5", "--update", "unit.h5"});
    (void)said_by({"collect", "set", "-o", "c.h5"});
    expect_turned_faces_told({"collect"}, "", {"-o", "c.h5", "--append"});
    // Those that are added are the odd ones, though they are more alike than all together.
    expect_said(Arguments{"collect"} + added + Arguments{"--append", "-o", "c.h5"},
                {"warning: mirror is a mirror image of the meshes of c.h5", "warning: large is ",
                 "larger than the meshes of c.h5" + units});
}

TEST_F(Unlike, ScansAreNamedWhereSizeIsPartOfTheModel)
{
    const TestMesh scan = bumpy_sphere(3, 0.2, 3);
    write_mesh(folder_ / "scan.ply", 10.0 * scan.points, scan.topology.faces());
    const auto fit = [&](const std::string& model) {
        return run_shape(folder_.path(),
                         {"fit", model, "scan.ply", "-o", join(model, "_fits/"), "--keep-failed"})
            .err;
    };
    const std::string said = fit("none.h5");
    EXPECT_NE(said.find("warning: scan is "), std::string::npos) << said;
    EXPECT_NE(said.find("larger than the meshes of none.h5"), std::string::npos) << said;
    EXPECT_EQ(fit("unit.h5").find("larger"), std::string::npos);
}

} // namespace
} // namespace shape::test
