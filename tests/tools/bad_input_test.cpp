// SPDX-License-Identifier: MIT

#include <gtest/gtest.h>
#include <hdf5.h>

#include <functional>

#include "libshape/base/format.h"
#include "libshape/io/mesh_file.h"
#include "tests/support/meshes.h"
#include "tests/tools/program.h"

namespace shape::test {
using namespace internal;
namespace {

/// Something that the program must refuse, and how.
struct BadInput
{
    std::string name;
    int exit_code;
    std::vector<std::string> said; ///< What the line on stderr must name.
    std::function<Arguments(const Folder&)> arrange;
};

void PrintTo(const BadInput& bad, std::ostream* out)
{
    *out << bad.name;
}

/// A folder with three meshes, their labels, and the collection and model made of them.
void fill(const Folder& folder)
{
    static const MadeOnce made([](const Folder& arena) {
        write_bumpy_spheres(arena);
        run_or_throw(arena, {"collect", "a.ply", "b.ply", "c.ply", "--labels", "labels.csv", "-o",
                             "good.h5"});
        run_or_throw(arena,
                     {"collect", "a.ply", "b.ply", "c.ply", "--store-derived", "-o", "derived.h5"});
        run_or_throw(arena, {"stats", "good.h5", "-o", "model.h5"});
    });
    made.copy_into(folder);
}

/// Collects one mesh file of the given name and content.
std::function<Arguments(const Folder&)> collecting(std::string name, std::string content)
{
    return [=](const Folder& folder) -> Arguments {
        folder.write(name, content);
        return {"collect", name, "-o", "out.h5"};
    };
}

/// Runs fixed arguments.
std::function<Arguments(const Folder&)> running(Arguments arguments)
{
    return [=](const Folder&) { return arguments; };
}

/// Runs arguments that read one more file.
std::function<Arguments(const Folder&)> running_with(std::string name, std::string content,
                                                     Arguments arguments)
{
    return [=](const Folder& folder) {
        folder.write(name, content);
        return arguments;
    };
}

/// Collects a.ply and a changed copy of it.
std::function<Arguments(const Folder&)> collecting_changed(
    std::function<void(Points&, Faces&)> change)
{
    return [=](const Folder& folder) -> Arguments {
        NamedMesh mesh = read_mesh(folder / "a.ply");
        change(mesh.points, mesh.faces);
        write_mesh(folder / "changed.ply", mesh.points, mesh.faces, MeshFormat::Ply);
        return {"collect", "a.ply", "changed.ply", "-o", "out.h5"};
    };
}

std::function<Arguments(const Folder&)> reconstructing(std::string lengths)
{
    return running_with("lengths.csv", lengths,
                        {"reconstruct", "--reference", "tetrahedron.obj", "--lengths",
                         "lengths.csv", "-o", "x.ply"});
}

/// Puts a dataset of other shape into a collection.
void replace_points(const std::string& file)
{
    const hid_t id = H5Fopen(file.c_str(), H5F_ACC_RDWR, H5P_DEFAULT);
    const hsize_t extents[] = {2, 5};
    const hid_t space = H5Screate_simple(2, extents, nullptr);
    H5Ldelete(id, "/points", H5P_DEFAULT);
    const hid_t data =
        H5Dcreate2(id, "/points", H5T_IEEE_F64LE, space, H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT);
    H5Dclose(data);
    H5Sclose(space);
    H5Fclose(id);
}

/// Takes the last face out of the topology of a file; also the attribute that tells, if asked.
std::function<Arguments(const Folder&)> with_a_face_less(const std::string& name,
                                                         bool without_checksum,
                                                         const Arguments& arguments)
{
    return [=](const Folder& folder) {
        folder.write("x.h5", folder.read(name));
        const hid_t id = H5Fopen((folder / "x.h5").c_str(), H5F_ACC_RDWR, H5P_DEFAULT);
        const hid_t old = H5Dopen2(id, "/topology/faces", H5P_DEFAULT);
        hsize_t extents[2];
        const hid_t old_space = H5Dget_space(old);
        H5Sget_simple_extent_dims(old_space, extents, nullptr);
        std::vector<int> faces(extents[0] * 3);
        H5Dread(old, H5T_NATIVE_INT, H5S_ALL, H5S_ALL, H5P_DEFAULT, faces.data());
        H5Sclose(old_space);
        H5Dclose(old);
        H5Ldelete(id, "/topology/faces", H5P_DEFAULT);
        extents[0] -= 1;
        const hid_t space = H5Screate_simple(2, extents, nullptr);
        const hid_t data = H5Dcreate2(id, "/topology/faces", H5T_STD_I32LE, space, H5P_DEFAULT,
                                      H5P_DEFAULT, H5P_DEFAULT);
        H5Dwrite(data, H5T_NATIVE_INT, H5S_ALL, H5S_ALL, H5P_DEFAULT, faces.data());
        H5Dclose(data);
        H5Sclose(space);
        if (without_checksum)
            H5Adelete(id, "faces_checksum");
        H5Fclose(id);
        return arguments;
    };
}

const std::string tetrahedron_vertices = "v 1 1 1\nv -1 -1 1\nv -1 1 -1\nv 1 -1 -1\n";
const std::string tetrahedron_obj = tetrahedron_vertices + "f 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n";
const std::string huge_ply =
    "ply\nformat binary_little_endian 1.0\nelement vertex 4000000000\n"
    "property double x\nproperty double y\nproperty double z\n"
    "element face 1\nproperty list uchar int vertex_indices\nend_header\n";
const std::string reversed_face_obj = tetrahedron_vertices + "f 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 4 3\n";

std::vector<BadInput> bad_meshes()
{
    return {
        {"EmptyObj", 3, {"x.obj"}, collecting("x.obj", "")},
        {"EmptyPly", 3, {"x.ply"}, collecting("x.ply", "")},
        {"EmptyOff", 3, {"x.off"}, collecting("x.off", "")},
        {"VerticesOnly", 3, {"x.obj"}, collecting("x.obj", tetrahedron_vertices)},
        {"TruncatedPly",
         3,
         {"x.ply"},
         [](const Folder& folder) -> Arguments {
             const std::string whole = folder.read("a.ply");
             folder.write("x.ply", whole.substr(0, whole.size() / 2));
             return {"collect", "x.ply", "-o", "out.h5"};
         }},
        {"NanCoordinate", 3, {"x.obj", "1", "nan"}, collecting("x.obj", "v nan 1 1\n")},
        {"InfiniteCoordinate", 3, {"x.obj", "1", "inf"}, collecting("x.obj", "v 0 inf 1\n")},
        {"OverflowingCoordinate", 3, {"x.obj", "1e999"}, collecting("x.obj", "v 0 1e999 1\n")},
        {"HugeCoordinates",
         3,
         {"x.obj", "longest edge, 1-2,"},
         collecting("x.obj", "v 0 0 0\nv 1e200 0 0\nv 0 1e200 0\nf 1 2 3\n")},
        {"MissingCoordinate", 3, {"x.obj", "2"}, collecting("x.obj", "v 0 0 1\nv 1 2\n")},
        {"IndexOutOfRange",
         3,
         {"x.obj", "9"},
         collecting("x.obj", tetrahedron_vertices + "f 1 2 9\n")},
        {"IndexZeroInObj",
         3,
         {"x.obj", "5", "0"},
         collecting("x.obj", tetrahedron_vertices + "f 0 1 2\n")},
        {"OffCountsBeyondTheFile",
         3,
         {"x.off", "4000000000"},
         collecting("x.off", "OFF\n4000000000 1 0\n0 0 0\n")},
        {"PlyCountsBeyondTheFile", 3, {"x.ply", "4000000000"}, collecting("x.ply", huge_ply)},
        {"PlyWithoutEndOfHeader", 3, {"x.ply"}, collecting("x.ply", "ply\nformat ascii 1.0\n")},
        {"QuadWithoutTriangulate",
         3,
         {"x.obj", "triangulate"},
         collecting("x.obj", tetrahedron_vertices + "f 1 2 3 4\n")},
        {"DegenerateFace",
         3,
         {"x.obj", "face 4"},
         collecting("x.obj", tetrahedron_obj + "f 1 1 2\n")},
        {"DuplicateFace",
         3,
         {"x.obj", "face 4"},
         collecting("x.obj", tetrahedron_obj + "f 3 2 1\n")},
        {"NonManifoldEdge",
         3,
         {"x.obj", "edge 0-1"},
         collecting("x.obj", tetrahedron_obj + "v 5 5 5\nf 1 2 5\n")},
        {"FlippedFace", 3, {"x.obj", "flip"}, collecting("x.obj", reversed_face_obj)},
        {"FaceWithoutArea",
         3,
         {"x.obj", "area"},
         collecting("x.obj", "v 0 0 0\nv 1 0 0\nv 2 0 0\nf 1 2 3\n")},
        {"OtherCounts",
         3,
         {"x.obj", "different counts"},
         running_with("x.obj", tetrahedron_obj, {"collect", "a.ply", "x.obj", "-o", "out.h5"})},
        {"PermutedVertices",
         3,
         {"changed.ply", "permuted"},
         collecting_changed([](Points&, Faces& faces) {
             faces = faces.unaryExpr([](int v) { return v == 0 ? 20 : v == 20 ? 0 : v; }).eval();
         })},
        {"FlippedMember",
         3,
         {"changed.ply", "flipped"},
         collecting_changed([](Points&, Faces& faces) { faces.col(1).swap(faces.col(2)); })},
        {"PermutedFaces",
         3,
         {"changed.ply", "another order"},
         collecting_changed([](Points&, Faces& faces) { faces.row(3).swap(faces.row(7)); })},
        {"UnknownEnding", 3, {"x.fbx"}, collecting("x.fbx", "Kaydara\n")},
        {"CollectionOfAnotherEnding",
         3,
         {"x.hdf5", "that of a collection or model of libshape is .h5"},
         collecting("x.hdf5", "")},
        {"MissingFile", 5, {"nowhere.ply"}, running({"collect", "nowhere.ply", "-o", "out.h5"})},
        {"DirectoryWithoutMeshes",
         3,
         {"empty"},
         running_with("empty/notes.txt", "", {"collect", "empty", "-o", "out.h5"})},
        {"OneNameTwice", 3, {"twice"}, running({"collect", "a.ply", "a.ply", "-o", "out.h5"})},
        {"CheckOfABrokenMesh",
         3,
         {"x.obj", "1 of 1"},
         running_with("x.obj", reversed_face_obj, {"check", "x.obj"})},
    };
}

std::vector<BadInput> bad_tables()
{
    const Arguments collect{"collect", "a.ply", "b.ply", "--labels", "l.csv", "-o", "out.h5"};
    const Arguments generate{"generate", "model.h5", "--scores-file", "s.csv", "-o", "new"};
    return {
        {"LabelsWithoutAMesh", 3, {"l.csv", "b"}, running_with("l.csv", "mesh,k\na,1\n", collect)},
        {"LabelsOfAMisspeltMesh",
         3,
         {"l.csv", "'b' is missing", "'B'"},
         running_with("l.csv", "mesh,k\na,1\nB,2\n", collect)},
        {"LabelsBetweenSemicolons",
         3,
         {"l.csv", "separator", "';'"},
         running_with("l.csv", "mesh;k\na;1\nb;2\n", collect)},
        {"LabelsOfAMeshTwice",
         3,
         {"l.csv", "a"},
         running_with("l.csv", "mesh,k\na,1\nb,2\na,3\n", collect)},
        {"ScoresWithoutAName",
         3,
         {"s.csv", "row 2", "no name"},
         running_with("s.csv", "mesh,pc1\na,0.1\n,0.2\n", generate)},
        {"LabelNamedAsTheSize",
         3,
         {"size", "rename"},
         running_with("l.csv", "mesh,size,side\na,1,x\nb,2,y\n",
                      {"groups", "a.ply", "b.ply", "--labels", "l.csv", "--by", "side",
                       "--adjust-for", "size", "-o", "g.csv"})},
        {"RaggedLabels", 3, {"l.csv", "3"}, running_with("l.csv", "mesh,k\na,1\nb\n", collect)},
        {"LabelsWithoutMeshColumn",
         3,
         {"l.csv", "mesh"},
         running_with("l.csv", "name,k\na,1\nb,2\n", collect)},
        {"LabelNamedAsAScore",
         3,
         {"pc1"},
         running_with(
             "l.csv", "mesh,pc1\na,1\nb,2\n",
             {"project", "model.h5", "a.ply", "b.ply", "--labels", "l.csv", "-o", "s.csv"})},
        {"ScoresThatAreNoNumbers",
         3,
         {"s.csv", "one", "pc1"},
         running_with("s.csv", "mesh,pc1\none,nan\n", generate)},
        {"ScoresOfTooManyModes",
         3,
         {"s.csv", "3 modes", "2"},
         running_with("s.csv", "mesh,pc1,pc2,pc3\none,0,0,0\n", generate)},
        {"ScoresWithAGap",
         3,
         {"s.csv", "'pc3'", "'pc2'"},
         running_with("s.csv", "mesh,pc1,pc3\none,0,1\n", generate)},
        {"ScoresWithoutColumns",
         3,
         {"s.csv", "no column pc1"},
         running_with("s.csv", "mesh,pc7\none,0\n", generate)},
        {"ScoresWithoutMeshColumn",
         3,
         {"s.csv", "first column is `name`"},
         running_with("s.csv", "name,pc1\none,0\n", generate)},
        {"ScoresWithoutRows", 3, {"s.csv", "rows"}, running_with("s.csv", "mesh,pc1\n", generate)},
        {"ScoresOfOneNameTwice",
         3,
         {"one", "twice"},
         running_with("s.csv", "mesh,pc1\none,0\none,1\n", generate)},
        {"ScoresOfANegativeSize",
         3,
         {"s.csv", "one", "> 0"},
         running_with("s.csv", "mesh,pc1,size\none,0,-1\n", generate)},
    };
}

std::vector<BadInput> bad_lengths()
{
    const std::string head = "v0,v1,length\n";
    const std::string five = head + "0,1,1\n0,2,1\n0,3,1\n1,2,1\n1,3,1\n";
    return {
        {"LengthsUnderOtherColumns", 3, {"lengths.csv"}, reconstructing("a,b,length\n0,1,1\n")},
        {"LengthsWithoutAnEdge", 3, {"lengths.csv", "2-3"}, reconstructing(five)},
        {"LengthsOfAnEdgeTwice",
         3,
         {"lengths.csv", "row 6", "twice"},
         reconstructing(five + "1,0,1\n")},
        {"LengthsOfNoEdge",
         3,
         {"lengths.csv", "row 1", "no edge 2-2 (vertices count from 0)"},
         reconstructing(head + "2,2,1\n")},
        {"LengthsOfAVertexOutOfRange",
         3,
         {"lengths.csv", "row 1", "v1"},
         reconstructing(head + "0,9,1\n")},
        {"LengthsOfAFractionalVertex",
         3,
         {"lengths.csv", "row 1", "0.5"},
         reconstructing(head + "0.5,1,1\n")},
        {"LengthsThatAreNotPositive",
         3,
         {"lengths.csv", "row 1", "> 0"},
         reconstructing(head + "0,1,-2\n")},
        {"LengthsThatAreNoNumbers",
         3,
         {"lengths.csv", "row 1", "long"},
         reconstructing(head + "0,1,long\n")},
    };
}

std::vector<BadInput> bad_hdf5()
{
    const Arguments info{"info", "x.h5"};
    const auto shortened = [](const std::string& name) {
        return [=](const Folder& folder) -> Arguments {
            const std::string whole = folder.read(name);
            folder.write("x.h5", whole.substr(0, whole.size() - whole.size() / 3));
            return {"info", "x.h5"};
        };
    };
    return {
        {"TextAsHdf5", 3, {"x.h5"}, running_with("x.h5", "no HDF5 at all\n", info)},
        {"EmptyHdf5", 3, {"x.h5"}, running_with("x.h5", "", info)},
        {"TruncatedCollection", 3, {"x.h5"}, shortened("good.h5")},
        {"TruncatedModel", 3, {"x.h5"}, shortened("model.h5")},
        {"DamagedCollection",
         3,
         {"x.h5"},
         [](const Folder& folder) -> Arguments {
             std::string bytes = folder.read("good.h5");
             for (std::size_t i = bytes.size() / 2; i < bytes.size() / 2 + 64; ++i)
                 bytes[i] = static_cast<char>(bytes[i] ^ 0x55);
             folder.write("x.h5", bytes);
             return {"stats", "x.h5", "-o", "out.h5"};
         }},
        {"PointsOfAnotherShape",
         3,
         {"x.h5", "points"},
         [](const Folder& folder) -> Arguments {
             folder.write("x.h5", folder.read("good.h5"));
             replace_points((folder / "x.h5").string());
             return {"stats", "x.h5", "-o", "out.h5"};
         }},
        {"CollectionWithAFaceLess",
         3,
         {"x.h5", "/topology/faces", "checksum"},
         with_a_face_less("good.h5", false, {"stats", "x.h5", "-o", "out.h5"})},
        {"CollectionWithAFaceLessAndNoChecksum",
         3,
         {"x.h5", "/dihedral_angles"},
         with_a_face_less("derived.h5", true, {"stats", "x.h5", "-o", "out.h5"})},
        {"ModelWithAFaceLess",
         3,
         {"x.h5", "/topology/faces", "checksum"},
         with_a_face_less("model.h5", false, {"generate", "x.h5", "--mean", "-o", "x.ply"})},
        {"ModelWithAFaceLessAndNoChecksum",
         3,
         {"x.h5", "/mean/dihedral_angles", "boundary"},
         with_a_face_less("model.h5", true, {"generate", "x.h5", "--mean", "-o", "x.ply"})},
        {"ModelAsCollection",
         3,
         {"model.h5: attribute format: is 'libshape model'", "`shape collect`"},
         running({"stats", "model.h5", "-o", "out.h5"})},
        {"CollectionAsModel",
         3,
         {"good.h5: attribute format: is 'libshape collection'", "`shape stats`"},
         running({"generate", "good.h5", "--mean", "-o", "x.ply"})},
        {"ModelForStatismo",
         3,
         {"s.h5: attribute format: is missing", "Statismo", "`shape stats`"},
         [](const Folder& folder) -> Arguments {
             (void)run_shape(folder.path(),
                             {"export", "model.h5", "--to", "statismo", "-o", "s.h5"});
             return {"project", "s.h5", "a.ply", "-o", "s.csv"};
         }},
        {"MissingModel", 5, {"no.h5"}, running({"generate", "no.h5", "--mean", "-o", "x.ply"})},
    };
}

std::vector<BadInput> bad_requests()
{
    return {
        {"StatisticsOfOneMesh", 3, {"2"}, running({"stats", "a.ply", "-o", "out.h5"})},
        {"DistancesOfOneMesh", 3, {"2", "1"}, running({"distance", "a.ply", "-o", "d.csv"})},
        {"DistancesColouredByAnUnknownLabel",
         3,
         {"colour", "mood"},
         running(
             {"distance", "good.h5", "-o", "d.csv", "--plot", "p.svg", "--color-by", "colour"})},
        {"DistancesWithLabelsOfSomeMeshes",
         3,
         {"l.csv", "b"},
         running_with("l.csv", "mesh,k\na,1\n",
                      {"distance", "a.ply", "b.ply", "--labels", "l.csv", "-o", "d.csv"})},
        {"LabelNamedAsACoordinateOfThePlane",
         3,
         {"mds1"},
         running_with("l.csv", "mesh,mds1\na,1\nb,2\n",
                      {"distance", "a.ply", "b.ply", "--labels", "l.csv", "-o", "d.csv"})},
        {"MeshNamedAsTheFirstColumn",
         3,
         {"mesh"},
         [](const Folder& folder) -> Arguments {
             folder.write("mesh.ply", folder.read("a.ply"));
             return {"distance", "mesh.ply", "b.ply", "-o", "d.csv"};
         }},
        {"QualityOfOneMesh", 3, {"1", "3"}, running({"quality", "a.ply", "-o", "q.csv"})},
        {"QualityOfMoreModesThanLeft",
         3,
         {"2 modes", "fold 1"},
         running({"quality", "good.h5", "-o", "q.csv", "--modes", "1,2"})},
        {"QualityInMoreFoldsThanMeshes",
         3,
         {"4 folds", "3"},
         running({"quality", "good.h5", "-o", "q.csv", "--folds", "4"})},
        {"QualityByAnUnknownLabel",
         3,
         {"colour", "mood"},
         running({"quality", "good.h5", "-o", "q.csv", "--leave-out", "colour"})},
        {"QualityLeavingOneMeshBehind",
         3,
         {"modes", "fold"},
         running({"quality", "good.h5", "-o", "q.csv", "--leave-out", "subject"})},
        {"MoreModesThanMeshesAllow",
         3,
         {"3", "2"},
         running({"stats", "good.h5", "-o", "out.h5", "--modes", "3"})},
        {"VarianceAboveOne",
         2,
         {"--variance", "1.5"},
         running({"stats", "good.h5", "-o", "out.h5", "--variance", "1.5"})},
        {"ReportOfACollection",
         3,
         {"good.h5", "libshape model"},
         running({"report", "good.h5", "-o", "page.html"})},
        {"ReportColouredByAnUnknownLabel",
         3,
         {"colour", "mood"},
         running({"report", "model.h5", "-o", "page.html", "--color-by", "colour"})},
        {"ModelOfOneMesh", 3, {"2 meshes"}, running({"stats", "a.ply", "-o", "out.h5"})},
        {"EqualMeshes",
         3,
         {"equal"},
         [](const Folder& folder) -> Arguments {
             const NamedMesh mesh = read_mesh(folder / "a.ply");
             write_mesh(folder / "larger.ply", 1.5 * mesh.points, mesh.faces);
             return {"stats", "a.ply", "larger.ply", "-o", "out.h5"};
         }},
        {"ProjectionOfAnotherTriangulation",
         3,
         {"triangulation"},
         running({"project", "model.h5", "tetrahedron.obj", "-o", "s.csv"})},
        {"PlotColouredByAnUnknownLabel",
         3,
         {"colour", "mood"},
         running({"project", "model.h5", "good.h5", "-o", "s.csv", "--plot", "s.svg", "--color-by",
                  "colour"})},
        {"ModeBeyondTheModel",
         3,
         {"--mode", "7", "1 to 2"},
         running({"generate", "model.h5", "--mode", "7", "--sigma", "1", "-o", "x.ply"})},
        {"MoreScoresThanModes",
         3,
         {"--scores", "3", "2"},
         running({"generate", "model.h5", "--scores", "0,0,0", "-o", "x.ply"})},
        {"StrictInfeasibleTarget",
         4,
         {"mode01_100.00", "face", "--strict"},
         running({"generate", "model.h5", "--mode", "1", "--sigma", "0:200:3", "--strict", "-o",
                  "new"})},
        {"UnknownLabel",
         3,
         {"colour"},
         running({"difference", "good.h5", "--pair-by", "colour", "--from", "mood=calm", "--to",
                  "mood=glad", "-o", "out.h5"})},
        {"EmptyGroup",
         3,
         {"sad"},
         running({"difference", "good.h5", "--pair-by", "subject", "--from", "mood=calm", "--to",
                  "mood=sad", "-o", "out.h5"})},
        {"WeightsThatDoNotSumToOne",
         3,
         {"0.5,0.6", "1.1"},
         running({"interpolate", "a.ply", "b.ply", "--weights", "0.5,0.6", "-o", "x.ply"})},
        {"WeightsOfAnotherNumber",
         3,
         {"3 weights for 2 meshes"},
         running({"interpolate", "a.ply", "b.ply", "--weights", "0.5,0.2,0.3", "-o", "x.ply"})},
        {"WeightsOutsideTheUnitInterval",
         3,
         {"-0.5", "--extrapolate"},
         running({"interpolate", "a.ply", "b.ply", "--weights", "-0.5,1.5", "-o", "x.ply"})},
        {"InterpolationOfOneMesh",
         3,
         {"a"},
         running({"interpolate", "a.ply", "--weights", "1", "-o", "x.ply"})},
        {"UnknownDataset", 3, {"cube", "torus", "scans"}, running({"synth", "cube", "-o", "new"})},
        {"BarbellsOfOddNumber",
         3,
         {"barbells", "7", "even"},
         running({"synth", "barbells", "--count", "7", "-o", "new"})},
        {"DatasetOfTooFewVertices",
         3,
         {"torus", "5"},
         running({"synth", "torus", "--vertices", "5", "-o", "new"})},
    };
}

/// What `interpolate` must refuse about paths, ranges and tagged parts.
std::vector<BadInput> bad_paths()
{
    const auto blending = [](Arguments more) {
        Arguments arguments{"interpolate", "a.ply", "b.ply", "c.ply", "-o", "new"};
        arguments.insert(arguments.end(), more.begin(), more.end());
        return arguments;
    };
    const auto blending_four = [](Arguments more) {
        return [=](const Folder& folder) {
            folder.write("twin.ply", folder.read("a.ply"));
            Arguments arguments{"interpolate", "a.ply", "b.ply", "c.ply", "twin.ply", "-o", "new"};
            arguments.insert(arguments.end(), more.begin(), more.end());
            return arguments;
        };
    };
    const auto refusing = [=](Arguments more) { return running(blending(std::move(more))); };
    const auto with_path = [=](std::string json) {
        return running_with("path.json", std::move(json), blending({"--path-file", "path.json"}));
    };
    const auto with_tags = [=](const std::string& option, std::string tags) {
        return running_with(
            "tags.txt", std::move(tags),
            blending({"--frames", "3", option, "tags.txt", "--scale-factors", "1,1,2"}));
    };
    const auto with_labels = [=](int faces, const std::string& label) {
        std::string file = join("ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\n",
                                "property float y\nproperty float z\nelement face ", faces,
                                "\nproperty list uchar int vertex_indices\nproperty int part\n",
                                "end_header\n0 0 0\n1 0 0\n0 1 0\n");
        for (int f = 0; f < faces; ++f)
            file += "3 0 1 2 5\n";
        return running_with("tags.ply", file,
                            blending({"--frames", "3", "--scale-faces", "tags.ply", "--scale-label",
                                      label, "--scale-factors", "1,1,2"}));
    };
    return {
        {"PatchOfThreeMeshes", 3, {"4", "3"}, refusing({"--path", "bilinear", "--frames", "3"})},
        {"PlaceOutsideThePatch",
         3,
         {"outside [0, 1]", "--extrapolate"},
         blending_four({"--path", "bilinear", "--at", "0.5,1.5"})},
        {"PolygonOfTwoMeshes",
         3,
         {"3 corners", "2 meshes"},
         running(
             {"interpolate", "a.ply", "b.ply", "-o", "new", "--path", "polygon", "--frames", "3"})},
        {"PointOutsideThePolygon",
         3,
         {"(5, 0)", "outside the polygon"},
         refusing({"--path", "polygon", "--at", "5,0"})},
        {"PolygonOfOtherCorners",
         3,
         {"4 corners for 3 meshes"},
         refusing({"--path", "polygon", "--frames", "3", "--polygon", "0,0:1,0:1,1:0,1"})},
        {"PolygonWithoutArea",
         3,
         {"not simple"},
         refusing({"--path", "polygon", "--frames", "3", "--polygon", "0,0:1,0:2,0"})},
        {"PolygonThatCrossesItself",
         3,
         {"not simple", "touch"},
         blending_four({"--path", "polygon", "--frames", "3", "--polygon", "0,0:2,2:2,0:0,2"})},
        {"TrackThatLeavesThePolygon",
         3,
         {"outside the polygon"},
         refusing({"--path", "polygon", "--frames", "3", "--track", "0,0:3,3"})},
        {"LineBeyondTheInputs",
         3,
         {"outside [0, 1]", "--extrapolate"},
         refusing({"--frames", "3", "--range", "0:1.25"})},
        {"SplineBeyondTheInputs",
         3,
         {"1.25", "[0, 1]"},
         refusing({"--path", "spline", "--frames", "3", "--range", "0:1.25", "--extrapolate"})},
        {"BeyondTheSafeRange",
         3,
         {"safe range", "face", "--force-range"},
         refusing({"--frames", "3", "--range", "0:90", "--extrapolate"})},
        {"WeightsBeyondTheSafeRange",
         3,
         {"safe range", "face", "--force-range"},
         refusing({"--weights", "90,-89,0", "--extrapolate"})},
        {"PathFileThatIsNoJson",
         3,
         {"error: path.json: line 1, column 2: is not JSON (syntax error"},
         with_path("frames: 3")},
        {"PathFileThatIsNoObject", 3, {"path.json", "object"}, with_path("[3]")},
        {"PathFileWithAnUnknownKey",
         3,
         {"path.json", "'frame'", "frames"},
         with_path(R"({"frame": 3})")},
        {"PathFileWithAKeyTwice",
         3,
         {"path.json", "'frames' occurs twice"},
         with_path(R"({"frames": 3, "frames": 4})")},
        {"PathFileWithAnUnknownPath",
         3,
         {"path.json: path", "curve", "bilinear"},
         with_path(R"({"path": "curve", "frames": 3})")},
        {"PathFileWithANumberOfAMillionDigits",
         3,
         {"path.json", "bytes more"},
         with_path("{\"frames\": " + std::string(1000000, '9') + "}")},
        {"PathFileWithOneFrame", 3, {"path.json: frames", "[2, "}, with_path(R"({"frames": 1})")},
        {"PathFileWithHalfAFrame", 3, {"frames", "integer"}, with_path(R"({"frames": 2.5})")},
        {"PathFileWithATextAsNumber",
         3,
         {"path.json: at[1][0]", "number"},
         with_path(R"({"path": "polygon", "at": [[0, 0], ["1", 0]]})")},
        {"PathFileWithATriple",
         3,
         {"path.json: track[0]", "pair"},
         with_path(R"({"path": "polygon", "frames": 3, "track": [[0, 0, 0]]})")},
        {"PathFileWithAnEmptyList",
         3,
         {"path.json: weights", "not empty"},
         with_path(R"({"weights": []})")},
        {"PathFileWithAWideGrid",
         3,
         {"path.json: grid[0]", "[2, 1000]"},
         with_path(R"({"path": "bilinear", "grid": [5000, 2]})")},
        {"MissingPathFile", 5, {"no.json"}, refusing({"--path-file", "no.json"})},
        {"TagsOutOfRange",
         3,
         {"tags.txt", "line 2", "vertex 42", "[0, 41]"},
         with_tags("--scale-vertices", "0 1\n42\n")},
        {"TaggedFacesOutOfRange",
         3,
         {"tags.txt", "line 1", "face 80", "[0, 79]"},
         with_tags("--scale-faces", "80\n")},
        {"TagsThatAreNoIntegers",
         3,
         {"tags.txt", "line 1", "2.5"},
         with_tags("--scale-vertices", "2.5\n")},
        {"NoTags", 3, {"tags.txt", "no vertex"}, with_tags("--scale-vertices", "# none\n")},
        {"MissingTags",
         5,
         {"no.txt"},
         refusing({"--frames", "3", "--scale-faces", "no.txt", "--scale-factors", "1,1,2"})},
        {"TagsWithAMissingLabel",
         3,
         {"a.ply", "vertex", "no property 'part'"},
         refusing({"--frames", "3", "--scale-vertices", "a.ply", "--scale-label", "part",
                   "--scale-factors", "1,1,2"})},
        {"LabelThatTagsNothing",
         3,
         {"tags.ply", "no face has a 'part' of 9"},
         with_labels(80, "part=9")},
        {"LabelsOfAnotherMesh",
         3,
         {"tags.ply", "1 value 'part', one a face; the meshes have 80"},
         with_labels(1, "part")},
        {"LabelInNoPlyFile",
         3,
         {"tags.txt", "ply"},
         running_with("tags.txt", "0",
                      blending({"--frames", "3", "--scale-vertices", "tags.txt", "--scale-label",
                                "part", "--scale-factors", "1,1,2"}))},
        {"LabelOfNoPart",
         2,
         {"--scale-label", "--scale-vertices"},
         refusing({"--frames", "3", "--scale-label", "part"})},
        {"FactorsOfAnotherNumber",
         3,
         {"2 factors for 3 meshes"},
         running_with("tags.txt", "0",
                      blending({"--frames", "3", "--scale-vertices", "tags.txt", "--scale-factors",
                                "1,2"}))},
        {"FactorThatIsNotPositive",
         3,
         {"--scale-factors", "-1"},
         running_with("tags.txt", "0",
                      blending({"--frames", "3", "--scale-vertices", "tags.txt", "--scale-factors",
                                "1,2,-1"}))},
        {"MeshesOfAnInterruptedRun",
         5,
         {"new.unfinished", "--resume", "--force"},
         running_with("new.unfinished/manifest.json", "{}", blending({"--frames", "3"}))},
        {"MeshesOfAnotherInterruptedRun",
         3,
         {"new.unfinished", "differs in", "--force"},
         running_with("new.unfinished/manifest.json", R"({"program": "0"})",
                      blending({"--frames", "3", "--resume"}))},
        {"DirectoryThatIsNoInterruptedRun",
         3,
         {"new.unfinished", "remove the directory"},
         running_with("new.unfinished/mine.txt", "mine", blending({"--frames", "3", "--force"}))},
    };
}

std::vector<BadInput> bad_outputs()
{
    return {
        {"ExistingFile",
         5,
         {"model.h5", "--force"},
         running({"stats", "good.h5", "-o", "model.h5"})},
        {"NameThatIsTooLong",
         5,
         {"error: xxx", ".h5: File name too long\n"},
         running({"stats", "good.h5", "-o", std::string(260, 'x') + ".h5"})},
        {"ExistingFileInADirectory",
         5,
         {"frame_0001.ply", "--force"},
         running_with("new/frame_0001.ply", "old",
                      {"interpolate", "a.ply", "b.ply", "--frames", "3", "-o", "new"})},
        {"ExistingDirectoryAsFile",
         5,
         {"dir.h5"},
         running_with("dir.h5/x", "", {"stats", "good.h5", "-o", "dir.h5", "--force"})},
        {"MissingParent", 5, {"no/where"}, running({"stats", "good.h5", "-o", "no/where/out.h5"})},
        {"MissingParentOfADirectory",
         5,
         {"no/where"},
         running({"synth", "torus", "-o", "no/where/new"})},
        {"UnwritableDirectory", 5, {"/proc"}, running({"stats", "good.h5", "-o", "/proc/out.h5"})},
        {"OutputThatIsAnInput",
         2,
         {"good.h5", "input"},
         running({"stats", "good.h5", "-o", "./good.h5", "--force"})},
        {"OutputThatIsAnInputMesh",
         2,
         {"a.ply", "input"},
         running(
             {"interpolate", "a.ply", "b.ply", "--weights", "0.5,0.5", "-o", "a.ply", "--force"})},
    };
}

class BadInputTest : public testing::TestWithParam<BadInput>
{
};

TEST_P(BadInputTest, IsRefusedInOneLineAndLeavesEverythingAsItWas)
{
    const BadInput& bad = GetParam();
    const Folder folder;
    fill(folder);
    folder.write("tetrahedron.obj", tetrahedron_obj);
    const Arguments arguments = bad.arrange(folder);
    const std::map<std::string, std::string> before = folder.content();

    const Outcome outcome = run_shape(folder.path(), arguments);

    EXPECT_EQ(outcome.exit_code, bad.exit_code) << outcome.err;
    EXPECT_EQ(line_count(outcome.err), 1) << outcome.err;
    EXPECT_LT(outcome.err.size(), 5000U);
    EXPECT_TRUE(outcome.err.starts_with("shape: error: ")) << outcome.err;
    for (const std::string& word : bad.said)
        EXPECT_NE(outcome.err.find(word), std::string::npos) << word << " in " << outcome.err;
    EXPECT_TRUE(folder.content() == before) << "a file was made or changed";
}

std::string case_name(const testing::TestParamInfo<BadInput>& bad)
{
    return bad.param.name;
}

INSTANTIATE_TEST_SUITE_P(Meshes, BadInputTest, testing::ValuesIn(bad_meshes()), case_name);
INSTANTIATE_TEST_SUITE_P(Tables, BadInputTest, testing::ValuesIn(bad_tables()), case_name);
INSTANTIATE_TEST_SUITE_P(Lengths, BadInputTest, testing::ValuesIn(bad_lengths()), case_name);
INSTANTIATE_TEST_SUITE_P(Hdf5, BadInputTest, testing::ValuesIn(bad_hdf5()), case_name);
INSTANTIATE_TEST_SUITE_P(Requests, BadInputTest, testing::ValuesIn(bad_requests()), case_name);
INSTANTIATE_TEST_SUITE_P(Paths, BadInputTest, testing::ValuesIn(bad_paths()), case_name);
INSTANTIATE_TEST_SUITE_P(Outputs, BadInputTest, testing::ValuesIn(bad_outputs()), case_name);

TEST(UnreadableInput, IsNamedInOneLineWithItsCause)
{
    const Folder folder;
    fill(folder);
    folder.write("closed/a.ply", folder.read("a.ply"));
    folder.write("open/a.ply", folder.read("a.ply"));
    const auto set = [&](std::filesystem::perms permissions) {
        for (const char* name : {"closed", "open/a.ply", "model.h5", "labels.csv"})
            std::filesystem::permissions(folder / name, permissions);
    };
    struct Reading
    {
        Arguments arguments;
        std::string said;
    };
    const std::vector<Reading> readings = {
        {{"collect", "closed", "-o", "out.h5"}, "closed"},
        {{"collect", "closed/a.ply", "-o", "out.h5"}, "closed/a.ply"},
        {{"collect", "open", "-o", "out.h5"}, "cannot read open/a.ply"},
        {{"check", "open"}, "cannot read open/a.ply"},
        {{"fit", "a.ply", "closed", "-o", "fitted"}, "closed"},
        {{"generate", "model.h5", "--mean", "-o", "x.ply"}, "cannot read model.h5"},
        {{"stats", "good.h5", "--labels", "labels.csv", "-o", "out.h5"}, "cannot read labels.csv"},
    };
    set(std::filesystem::perms::none);
    std::vector<Outcome> outcomes;
    for (const Reading& reading : readings)
        outcomes.push_back(run_shape(folder.path(), reading.arguments, {.as_ordinary_user = true}));
    set(std::filesystem::perms::owner_all);
    if (outcomes.front().exit_code == 127)
        GTEST_SKIP() << "root cannot give up reading everything here";
    for (std::size_t i = 0; i < readings.size(); ++i) {
        EXPECT_EQ(outcomes[i].exit_code, 5) << readings[i].said;
        EXPECT_EQ(outcomes[i].err, "shape: error: " + readings[i].said + ": Permission denied\n");
    }
    EXPECT_FALSE(folder.has("out.h5"));
}

} // namespace
} // namespace shape::test
