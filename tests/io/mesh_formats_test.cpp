// SPDX-License-Identifier: MIT

#include <gtest/gtest.h>

#include <algorithm>
#include <cctype>
#include <cstring>

#include "libshape/base/error.h"
#include "libshape/base/format.h"
#include "libshape/base/random.h"
#include "libshape/base/to_size.h"
#include "libshape/io/mesh_formats.h"
#include "libshape/io/mesh_write_options.h"
#include "tests/support/files.h"
#include "tests/support/matrices.h"
#include "tests/support/meshes.h"

// STL, VTK, VTP and GLB, and what a file holds beside a mesh.

namespace shape {
namespace {

using namespace internal;
using test::TemporaryDirectory;
using test::TestMesh;

MeshFileContent read(const std::string& name, std::string_view bytes, bool triangulate = false)
{
    static const TemporaryDirectory directory;
    test::write_bytes(directory / name, bytes);
    return read_mesh_members(directory / name, {.triangulate = triangulate});
}

std::string refusal(const std::string& name, std::string_view bytes)
{
    return test::message_of<InvalidInput>([&] { (void)read(name, bytes); });
}

const Points square = (Points(4, 3) << 0, 0, 0, 1, 0, 0, 1, 1, 0.5, 0, 1, 0).finished();
const Faces halves = (Faces(2, 3) << 0, 1, 2, 0, 2, 3).finished();

void expect_square(const MeshFileContent& content)
{
    ASSERT_EQ(content.meshes.size(), 1U);
    EXPECT_EQ(content.meshes[0].points, square);
    EXPECT_EQ(content.meshes[0].faces, halves);
}

template <class Value>
std::string bytes_of(std::initializer_list<Value> values, bool big_endian = false)
{
    std::string bytes;
    for (Value value : values) {
        std::string part(sizeof value, '\0');
        std::memcpy(part.data(), &value, sizeof value);
        if (big_endian)
            std::reverse(part.begin(), part.end());
        bytes += part;
    }
    return bytes;
}

const std::string stl_text =
    "solid two words\n"
    "facet normal 0 0 1\n outer loop\n  vertex 0 0 0\n  vertex 1 0 0\n  vertex 1 1 0.5\n endloop\n"
    "endfacet\nfacet normal 0 0 1\nouter loop\nvertex -0 0 0\nvertex 1.0 1 5e-1\nvertex 0 1 0\n"
    "endloop\nendfacet\nendsolid\n";

TEST(StlFile, MergesEqualCornersInTheOrderOfTheirFirstAppearance)
{
    const MeshFileContent text = read("a.stl", stl_text);
    expect_square(text);
    EXPECT_EQ(text.merged_corners, 6);
    EXPECT_FALSE(text.single_precision);
    std::string capitals = stl_text;
    std::ranges::transform(capitals, capitals.begin(),
                           [](unsigned char c) { return std::toupper(c); });
    expect_square(read("a.stl", capitals));

    const TestMesh mesh = test::icosphere(2);
    for (const bool ascii : {false, true}) {
        const TemporaryDirectory directory;
        write_mesh(directory / "b.stl", mesh.points, mesh.topology.faces(), MeshFormat::Stl,
                   {.ascii = ascii});
        const MeshFileContent read = read_mesh_members(directory / "b.stl");
        EXPECT_EQ(read.single_precision, !ascii);
        EXPECT_EQ(read.merged_corners, 3 * mesh.topology.face_count());
        // A renumbering, found from the corners: the shape is the same.
        const Faces& faces = read.meshes[0].faces;
        int next = 0;
        for (Eigen::Index f = 0; f < faces.rows(); ++f)
            for (int c = 0; c < 3; ++c) {
                EXPECT_LE(faces(f, c), next);
                next = std::max(next, faces(f, c) + 1);
                const Eigen::RowVector3d wanted = mesh.points.row(mesh.topology.faces()(f, c));
                EXPECT_EQ(Eigen::RowVector3f(read.meshes[0].points.row(faces(f, c)).cast<float>()),
                          Eigen::RowVector3f(wanted.cast<float>()));
            }
        EXPECT_EQ(next, mesh.points.rows());
    }
}

TEST(StlFile, TellsBytesFromTextByItsLength)
{
    std::string bytes = "solid as some programs begin binary files";
    bytes.resize(80, ' ');
    bytes += bytes_of<std::uint32_t>({2});
    bytes += bytes_of<float>({0, 0, 1, 0, 0, 0, 1, 0, 0, 1, 1, 0.5F}) + "xx";
    bytes += bytes_of<float>({0, 0, 1, 0, 0, 0, 1, 1, 0.5F, 0, 1, 0}) + "xx";
    expect_square(read("a.stl", bytes));
    expect_square(read("e.stl", "\xEF\xBB\xBF" + stl_text));
    expect_square(read("f.stl", " \n" + stl_text));
    EXPECT_NE(refusal("b.stl", std::string(200, '\1')).find("byte 80"), std::string::npos);
    std::string longer = bytes;
    longer[0] = 'x';
    EXPECT_NE(refusal("l.stl", longer + std::string(6, '\0')).find("cut it off (truncate -s 184"),
              std::string::npos);
    // Never to be cut off: the count was not written.
    std::string uncounted = longer;
    std::fill_n(uncounted.begin() + 80, 4, '\0');
    EXPECT_NE(refusal("u.stl", uncounted).find("2 more faces: the count was not written"),
              std::string::npos);
    EXPECT_NE(refusal("z.stl", longer + std::string(50, '\0')).find("cut it off (truncate -s 184"),
              std::string::npos);
    EXPECT_NE(refusal("s.stl", longer.substr(0, 150)).find("it was cut off"), std::string::npos);
    EXPECT_NE(
        refusal("c.stl", "solid\nfacet normal 0 0 1\nouter loop\nvertex 0 0 nan\n").find("line 4"),
        std::string::npos);
    EXPECT_NE(refusal("d.stl", stl_text.substr(0, stl_text.size() - 10)).find("endsolid"),
              std::string::npos);
}

const std::string vtk_head = "# vtk DataFile Version 3.0\nany title\n";

TEST(VtkFile, ReadsEveryFormOfPolydata)
{
    const std::string points = "DATASET POLYDATA\nPOINTS 4 double\n0 0 0 1 0 0\n1 1 0.5 0 1 0\n";
    expect_square(
        read("a.vtk", vtk_head + "ASCII\n" + points + "POLYGONS 2 8\n3 0 1 2\n3 0 2 3\n"));
    expect_square(
        read("b.vtk", vtk_head + "ASCII\n" + points +
                          "METADATA\nINFORMATION 0\n\nLINES 1 3\n2 0 1\n\nPOLYGONS 2 8\n3 0 "
                          "1 2 3 0 2 3\nPOINT_DATA 4\nSCALARS x float\nwhatever follows"));
    expect_square(read("l.vtk", vtk_head +
                                    "ascii\ndataset polydata\nPoints 4 Double\n0 0 0 1 0 0\n1 "
                                    "1 0.5 0 1 0\npolygons 2 8\n3 0 1 2\n3 0 2 3\n"));
    // A strip turns every other triangle over: 1 2 0, then 2 and 0 exchanged before 3.
    const MeshFileContent strip =
        read("c.vtk", vtk_head + "ASCII\n" + points + "TRIANGLE_STRIPS 1 5\n4 1 2 0 3\n");
    EXPECT_EQ(strip.meshes[0].faces, (Faces(2, 3) << 1, 2, 0, 0, 2, 3).finished());
    expect_square(read("d.vtk", "# vtk DataFile Version 5.1\n\nASCII\n" + points +
                                    "POLYGONS 3 6\nOFFSETS vtktypeint64\n0 3 6\nCONNECTIVITY "
                                    "vtktypeint64\n0 1 2 0 2 3\n"));
    EXPECT_NE(test::message_of<InvalidInput>([&] {
                  (void)read("e.vtk", vtk_head + "ASCII\n" + points + "POLYGONS 1 5\n4 0 1 2 3\n");
              }).find("4 corners"),
              std::string::npos);
    expect_square(read("e.vtk", vtk_head + "ASCII\n" + points + "POLYGONS 1 5\n4 0 1 2 3\n", true));
    const MeshFileContent bytes =
        read("f.vtk", vtk_head + "BINARY\nDATASET POLYDATA\nFIELD FieldData 1\nTime 1 1 float\n" +
                          bytes_of<float>({0.5F}, true) + "\nPOINTS 4 float\n" +
                          bytes_of<float>({0, 0, 0, 1, 0, 0, 1, 1, 0.5F, 0, 1, 0}, true) +
                          "\nPOLYGONS 2 8\n" +
                          bytes_of<std::int32_t>({3, 0, 1, 2, 3, 0, 2, 3}, true) + "\n");
    expect_square(bytes);
    EXPECT_TRUE(bytes.single_precision);
}

TEST(VtkFile, PassesOverTextsAndBitsOfFields)
{
    const std::string points = "POINTS 4 double\n0 0 0 1 0 0\n1 1 0.5 0 1 0\n";
    expect_square(read("a.vtk", vtk_head +
                                    "ASCII\nDATASET POLYDATA\nFIELD FieldData 2\n"
                                    "who 1 3 string\nfirst\n\nPOINTS%20x\n"
                                    "odd 1 3 bit\n1 0 1\n" +
                                    points + "POLYGONS 2 8\n3 0 1 2\n3 0 2 3\n"));
    // A text is bytes behind their number, of one, two, four or eight bytes.
    const std::string texts = std::string("\xc5") + "first\xc0" +
                              ("\x80\x46" + std::string(70, 'x')) +
                              (std::string("\x40\x00\x4e\x20", 4) + std::string(20000, '\n')) +
                              (std::string("\x00\x00\x00\x00\x00\x00\x00\x02", 8) + "ab");
    const std::string head = vtk_head +
                             "BINARY\nDATASET POLYDATA\nFIELD FieldData 2\n"
                             "who 1 5 string\n";
    expect_square(read("b.vtk", head + texts + "\nodd 1 11 bit\nU@\nPOINTS 4 float\n" +
                                    bytes_of<float>({0, 0, 0, 1, 0, 0, 1, 1, 0.5F, 0, 1, 0}, true) +
                                    "\nPOLYGONS 2 8\n" +
                                    bytes_of<std::int32_t>({3, 0, 1, 2, 3, 0, 2, 3}, true) + "\n"));
    for (const std::string& rest :
         {std::string("\xc5"
                      "fir"),
          std::string("\x80"), std::string("\x00\xff\xff\xff\xff\xff\xff\xff", 8)})
        EXPECT_NE(
            test::message_of<InvalidInput>([&] { (void)read("c.vtk", head + rest); }).find("byte"),
            std::string::npos);
    EXPECT_NE(test::message_of<InvalidInput>([&] {
                  (void)read("d.vtk", vtk_head +
                                          "ASCII\nDATASET POLYDATA\nFIELD f 1\n"
                                          "who 1 900000000000 string\nx\n");
              }).find("ends within"),
              std::string::npos);
}

TEST(VtkFile, RefusesInALineWhatItIsNot)
{
    const std::string ascii = vtk_head + "ASCII\n";
    const std::string points = "DATASET POLYDATA\nPOINTS 3 float\n0 0 0 1 0 0 0 1 0\n";
    for (const auto& [text, rule] : std::vector<std::pair<std::string, std::string>>{
             {"ply\n", "line 2: must start with '# vtk"},
             {"# vtk DataFile Version 9.0\n\nASCII\n", "version"},
             {ascii + "DATASET UNSTRUCTURED_GRID\n", "must be POLYDATA"},
             {ascii + "POINTS 3 float\n", "must be 'DATASET POLYDATA'"},
             {ascii + "DATASET POLYDATA\nPOINTS 900 float\n0 0 0\n", "do not fit"},
             {ascii + "DATASET POLYDATA\nPOINTS -3 float\n", "must be an integer >= 0"},
             {ascii + "DATASET POLYDATA\nPOINTS 9223372036854775808 float\n",
              "'9223372036854775808', is beyond what can be counted, 2^63 - 1"},
             {ascii + points + "POLYGONS 1 4\n3 0 1 9223372036854775808\n",
              "an index is '9223372036854775808', is beyond what can be counted"},
             {ascii + "DATASET POLYDATA\nPOINTS 1 bit\n", "of type 'bit'"},
             {ascii + "DATASET POLYDATA\nPOINTS 1 float\n0 0 nan\n", "'nan'"},
             {ascii + points + "POLYGONS 1 4\n3 0 1 3\n", "names vertex 3 of 3"},
             {ascii + points + "POLYGONS 1 4\n9 0 1 2\n", "has 9 corners"},
             {ascii + points + "POLYGONS 2 4\n3 0 1 2\n", "holds 1 cell"},
             {ascii + points + "MOLECULES 2\n", "unknown keyword"},
             {ascii + points, "0 faces"}}) {
        const std::string message = refusal("a.vtk", text);
        EXPECT_NE(message.find(rule), std::string::npos) << message << " for " << text;
        EXPECT_EQ(message.find('\n'), std::string::npos);
    }
}

const std::string vtp_text =
    "<?xml version=\"1.0\"?>\n<VTKFile type=\"PolyData\" version=\"0.1\" "
    "byte_order=\"LittleEndian\">"
    "<PolyData><Piece NumberOfPoints=\"4\" NumberOfPolys=\"2\"><PointData/><Points>"
    "<DataArray type=\"Float64\" NumberOfComponents=\"3\" format=\"ascii\">0 0 0 1 0 0\n1 1 0.5 0 "
    "1 0"
    "</DataArray></Points><Polys><DataArray type=\"Int32\" Name=\"connectivity\" "
    "format=\"ascii\">0 1 "
    "2 0 2 3</DataArray><DataArray type=\"Int32\" Name=\"offsets\" format=\"ascii\">3 6</DataArray>"
    "</Polys></Piece></PolyData></VTKFile>\n";

std::string replaced(std::string text, const std::string& what, const std::string& by)
{
    EXPECT_NE(text.find(what), std::string::npos) << what;
    return text.replace(text.find(what), what.size(), by);
}

#define SKIP_WITHOUT_VTP(name)                                                     \
    try {                                                                          \
        (void)read("probe.vtp", vtp_text);                                         \
    } catch (const InvalidInput& error) {                                          \
        if (std::string(error.what()).find("libpugixml-dev") != std::string::npos) \
            GTEST_SKIP() << "built without pugixml: .vtp files are not read";      \
    }

TEST(VtpFile, ReadsTextBase64AndCompressedArrays)
{
    SKIP_WITHOUT_VTP();
    expect_square(read("a.vtp", vtp_text));
    // The head in four bytes and the numbers behind it, in one piece of base 64.
    const std::string inlined =
        replaced(replaced(vtp_text, "format=\"ascii\">3 6<", "format=\"binary\">CAAAAAMAAAAGAAAA<"),
                 "format=\"ascii\">0 1 2 0 2 3<",
                 "format=\"binary\">GAAAAAAAAAABAAAAAgAAAAAAAAACAAAAAwAAAA==<");
    expect_square(read("b.vtp", inlined));
    // The head in a piece of its own, and one block packed by zlib (Python's zlib.compress).
    std::string packed =
        replaced(vtp_text, "byte_order", "compressor=\"vtkZLibDataCompressor\" byte_order");
    packed = replaced(packed, "format=\"ascii\">3 6<",
                      "format=\"binary\">AQAAAACAAAAIAAAADgAAAA==eJxjZmBgYANiAAA4AAo=<");
    expect_square(read("c.vtp", packed));
}

TEST(VtpFile, RefusesInALineWhatItIsNot)
{
    SKIP_WITHOUT_VTP();
    for (const auto& [what, by, rule] : std::vector<std::array<std::string, 3>>{
             {"PolyData\" v", "ImageData\" v", "PolyData"},
             {"</VTKFile>", "", "whole XML file"},
             {"0.5", "x", "must be finite numbers"},
             {"3 6", "3", "holds fewer"},
             {"3 6", "3 6 7", "holds more"},
             {"3 6", "7 6", "ends at entry"},
             {"Int32", "Float32", "integer type"},
             {"0 2 3<", "0 2 4<", "names vertex 4"},
             {"\"4\"", "\"4000000000\"", "NumberOfPoints"},
             {"\"4\"", "\"4000000000\"", "must be an integer in [0, 2147483647]"},
             {"2 0 2 3<", "2 0 2 9223372036854775808<",
              "holds '9223372036854775808', is beyond what can be counted"},
             {"ascii\">3 6", "appended\" offset=\"9\">", "behind"},
             {"Components=\"3\"", "Components=\"2\"", "three"}}) {
        const std::string message = refusal("a.vtp", replaced(vtp_text, what, by));
        EXPECT_NE(message.find(rule), std::string::npos) << message << " for " << by;
    }
}

TEST(MeshWriteOptions, ScalarsAreNotCalledAsColoursAre)
{
    const test::TestMesh mesh = test::tetrahedron();
    const test::TemporaryDirectory directory;
    const Eigen::VectorXd values = Eigen::VectorXd::Zero(mesh.points.rows());
    const VertexColours colours = VertexColours::Zero(mesh.points.rows(), 3);
    const auto write = [&](const std::string& name, MeshFormat format, const VertexColours& with) {
        write_mesh(directory / join(name, file_ending(format)), mesh.points, mesh.topology.faces(),
                   format, {.scalars = {{name, values}}, .colours = with});
    };
    for (const MeshFormat format : {MeshFormat::Ply, MeshFormat::Vtk, MeshFormat::Vtp})
        for (const std::string name : {"red", "green", "blue", "colours"}) {
            SCOPED_TRACE(name + file_ending(format));
            EXPECT_NO_THROW(write(name, format, {}));
            std::filesystem::remove(directory / join(name, file_ending(format)));
            // PLY has three properties for them, VTK an array.
            if ((name == "colours") == (format == MeshFormat::Ply)) {
                EXPECT_NO_THROW(write(name, format, colours));
                continue;
            }
            const std::string message =
                test::message_of<InvalidInput>([&] { write(name, format, colours); });
            EXPECT_NE(message.find(join("'", name, "': colours are written under this name")),
                      std::string::npos)
                << message;
            EXPECT_FALSE(std::filesystem::exists(directory / join(name, file_ending(format))));
        }
}

TEST(MeshWriteOptions, RoundTripInEveryFormThatHasDoubles)
{
    const TemporaryDirectory directory;
    const TestMesh mesh = test::bumpy_sphere(2, 0.2, 3);
    const Eigen::VectorXd heat = test::random_matrix(mesh.points.rows(), 1, 1);
    VertexColours colours(mesh.points.rows(), 3);
    for (Eigen::Index i = 0; i < colours.size(); ++i)
        colours.data()[i] = static_cast<std::uint8_t>(i);
    for (const MeshFormat format : {MeshFormat::Ply, MeshFormat::Vtk, MeshFormat::Vtp})
        for (const bool ascii : {false, true})
            for (const bool is_single : {false, true}) {
                const std::filesystem::path path = directory / join("x", file_ending(format));
                SCOPED_TRACE(path);
                write_mesh(path, mesh.points, mesh.topology.faces(), format,
                           {.ascii = ascii,
                            .single_precision = is_single,
                            .scalars = {{"heat", heat}, {"cold", -heat}},
                            .quality = format == MeshFormat::Ply ? "cold" : "",
                            .colours = colours});
                if (format == MeshFormat::Vtp)
                    SKIP_WITHOUT_VTP();
                const MeshFileContent read = read_mesh_members(path);
                // Text of single precision is the shortest that gives the float back.
                const auto stored = [&](const auto& values) {
                    return is_single ? values.template cast<float>().template cast<double>().eval()
                                     : values.eval();
                };
                EXPECT_EQ(stored(read.meshes[0].points), stored(mesh.points));
                EXPECT_EQ(read.meshes[0].faces, mesh.topology.faces());
                if (format != MeshFormat::Ply) {
                    EXPECT_EQ(read.single_precision, is_single);
                    continue;
                }
                EXPECT_EQ(stored(read_vertex_scalar(path, "heat")), stored(heat));
                EXPECT_EQ(stored(read_vertex_scalar(path, "quality")), stored(-heat));
                EXPECT_EQ(read_vertex_scalar(path, "green"),
                          Eigen::VectorXd(colours.col(1).cast<double>()));
            }
}

TEST(MeshWriteOptions, ThatAFormatCannotKeepAreRefused)
{
    const TemporaryDirectory directory;
    const TestMesh mesh = test::tetrahedron();
    const auto message = [&](MeshFormat format, const MeshWriteOptions& options) {
        return test::message_of<InvalidInput>([&] {
            write_mesh(directory / "x", mesh.points, mesh.topology.faces(), format, options);
        });
    };
    const std::vector<VertexScalar> heat{{"heat", Eigen::VectorXd::Ones(4)}};
    EXPECT_NE(message(MeshFormat::Glb, {.ascii = true}).find("text"), std::string::npos);
    EXPECT_NE(message(MeshFormat::Obj, {.single_precision = true}).find("single"),
              std::string::npos);
    EXPECT_NE(message(MeshFormat::Off, {.scalars = heat}).find("values"), std::string::npos);
    EXPECT_NE(message(MeshFormat::Stl, {.colours = VertexColours::Zero(4, 3)}).find("colours"),
              std::string::npos);
    EXPECT_NE(message(MeshFormat::Ply, {.colours = VertexColours::Zero(3, 3)}).find("3 rows"),
              std::string::npos);
    EXPECT_NE(message(MeshFormat::Ply, {.scalars = heat, .quality = "cold"}).find("'cold'"),
              std::string::npos);
    EXPECT_NE(message(MeshFormat::Vtp, {.scalars = heat, .quality = "heat"}).find("`quality`"),
              std::string::npos);
    EXPECT_NE(message(MeshFormat::Ply, {.obj_template = std::make_shared<ObjTemplate>()})
                  .find("template"),
              std::string::npos);
    EXPECT_NE(message(MeshFormat::Obj, {.obj_template = std::make_shared<ObjTemplate>()})
                  .find("other faces"),
              std::string::npos);
    EXPECT_TRUE(directory.names().empty());
    Points far = mesh.points;
    far(0, 0) = 1e39;
    EXPECT_NE(test::message_of<InvalidInput>([&] {
                  write_mesh(directory / "x.stl", far, mesh.topology.faces());
              }).find("single precision"),
              std::string::npos);
}

TEST(ObjTemplate, KeepsTextureMaterialsAndPolygonsAndComputesNormalsAnew)
{
    const TemporaryDirectory directory;
    std::filesystem::create_directory(directory / "out");
    test::write_bytes(directory / "skin.mtl", "newmtl skin\n");
    test::write_bytes(
        directory / "t.obj",
        "# made by hand\nmtllib skin.mtl\nv 9 9 9 0.5 0.5 0.5\nv 1 0 0\nv 1 1 0\r\nv 0 1 "
        "0\nvt 0 0\nvt 1 0.25\nvn 1 0 0\nvn 0 1 0\nusemtl skin\nf 1/1/1 2/2/1 3/1/1 "
        "4/2/1\n");
    const ObjTemplate made = read_obj_template(directory / "t.obj", directory / "out");
    EXPECT_EQ(made.faces, halves);
    Points flat = square;
    flat(2, 2) = 0.0;
    write_mesh(directory / "out/x.obj", flat, halves, MeshFormat::Obj,
               {.obj_template = std::make_shared<ObjTemplate>(made)});
    EXPECT_EQ(
        test::read_bytes(directory / "out/x.obj"),
        "# made by hand\nmtllib ../skin.mtl\nv 0 0 0 0.5 0.5 0.5\nv 1 0 0\nv 1 1 0\nv 0 1 0\nvt "
        "0 0\nvt 1 0.25\nvn 0 0 1\nvn 0 1 0\nusemtl skin\nf 1/1/1 2/2/1 3/1/1 4/2/1\n");
    test::write_bytes(directory / "loose.obj",
                      "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 7 7 7\nf 1 2 3 4\n");
    const auto loose =
        std::make_shared<ObjTemplate>(read_obj_template(directory / "loose.obj", directory.path()));
    EXPECT_NE(test::message_of<InvalidInput>([&] {
                  write_mesh(directory / "y.obj", flat, halves, MeshFormat::Obj,
                             {.obj_template = loose});
              }).find("5 vertices, the mesh 4"),
              std::string::npos);
    EXPECT_NE(test::message_of<InvalidInput>([&] {
                  (void)read_obj_template(directory / "skin.ply", directory.path());
              }).find("must be an OBJ"),
              std::string::npos);
}

/// A GLB file of a description and a buffer.
std::string glb_of(std::string json, std::string buffer)
{
    json.append((4 - json.size() % 4) % 4, ' ');
    buffer.append((4 - buffer.size() % 4) % 4, '\0');
    const auto number = [](std::size_t value) {
        return bytes_of<std::uint32_t>({static_cast<std::uint32_t>(value)});
    };
    return "glTF" + number(2) + number(28 + json.size() + buffer.size()) + number(json.size()) +
           "JSON" + json + number(buffer.size()) + std::string("BIN\0", 4) + buffer;
}

const std::string square_floats = bytes_of<float>({0, 0, 0, 1, 0, 0, 1, 1, 0.5F, 0, 1, 0});
const std::string glb_json =
    R"({"asset":{"version":"2.0"},"scene":0,"scenes":[{"nodes":[0]}],
"nodes":[{"children":[1],"translation":[10,0,0]},{"mesh":0,"scale":[2,2,2]}],
"meshes":[{"primitives":[{"attributes":{"POSITION":0},"indices":1,"targets":[{"POSITION":2},{}]}],
"extras":{"targetNames":["smile","smile"]}}],
"accessors":[{"bufferView":0,"componentType":5126,"count":4,"type":"VEC3"},
{"bufferView":1,"componentType":5121,"count":6,"type":"SCALAR"},
{"componentType":5126,"count":4,"type":"VEC3","sparse":{"count":1,
"indices":{"bufferView":2,"componentType":5123},"values":{"bufferView":3}}}],
"bufferViews":[{"buffer":0,"byteLength":48},{"buffer":0,"byteOffset":48,"byteLength":6},
{"buffer":0,"byteOffset":54,"byteLength":2},{"buffer":0,"byteOffset":56,"byteLength":12}],
"buffers":[{"byteLength":68}]})";
const std::string glb_buffer = square_floats + std::string("\0\1\2\0\2\3", 6) +
                               bytes_of<std::uint16_t>({2}) + bytes_of<float>({0, 0, 1});

TEST(GlbFile, ReadsNodesSmallIndicesAndSparseTargets)
{
    const MeshFileContent content = read("face.glb", glb_of(glb_json, glb_buffer));
    ASSERT_EQ(content.meshes.size(), 3U);
    EXPECT_EQ(content.meshes[0].name, "face");
    EXPECT_EQ(content.meshes[1].name, "face_smile");
    EXPECT_EQ(content.meshes[2].name, "face_smile (2)");
    Points placed = 2.0 * square;
    placed.col(0).array() += 10.0;
    EXPECT_EQ(content.meshes[0].points, placed);
    EXPECT_EQ(content.meshes[2].points, placed);
    placed(2, 2) += 2.0;
    EXPECT_EQ(content.meshes[1].points, placed);
    EXPECT_EQ(content.meshes[0].faces, halves);
    // Without a scene, the nodes that are no node's child are where the tree begins.
    const std::string library = replaced(glb_json, R"("scene":0,"scenes":[{"nodes":[0]}],)", "");
    EXPECT_EQ(read("face.glb", glb_of(library, glb_buffer)).meshes[1].points, placed);
    // A node that mirrors its mesh turns the faces as well.
    std::string mirroring = glb_json;
    mirroring.replace(mirroring.find("[2,2,2]"), 7, "[2,2,-2]");
    Faces turned = halves;
    turned.col(1).swap(turned.col(2));
    const MeshFileContent mirrored = read("face.glb", glb_of(mirroring, glb_buffer));
    for (const NamedMesh& mesh : mirrored.meshes)
        EXPECT_EQ(mesh.faces, turned);
    EXPECT_EQ(mirrored.meshes[0].points(2, 2), -1.0);
}

TEST(GlbFile, PrimitivesThatShareTheirVerticesAreOneSurface)
{
    // A triangle of each material: the same vertices, or vertices of their own.
    const std::string triangle =
        R"({"attributes":{"POSITION":0},"indices":1,"targets":[{"POSITION":2},{}]})";
    const std::string half = replaced(glb_json, "\"count\":6", "\"count\":3");
    const auto of = [&](const std::string& second) {
        return read("x.glb", glb_of(replaced(half, triangle, triangle + "," + second), glb_buffer));
    };
    const MeshFileContent shared = of(triangle);
    EXPECT_EQ(shared.meshes[0].points.rows(), 4);
    EXPECT_EQ(shared.meshes[0].faces.rows(), 2);
    EXPECT_EQ(shared.meshes[1].points.rows(), 4);
    EXPECT_EQ(of(replaced(triangle, "{\"POSITION\":2},{}", "{},{}")).meshes[1].points.rows(), 8);
}

TEST(GlbFile, LinesAndPointsBesideTrianglesAreSkipped)
{
    const std::string triangles =
        R"({"attributes":{"POSITION":0},"indices":1,"targets":[{"POSITION":2},{}]})";
    for (const char* mode : {"0", "1", "2", "3"}) {
        const std::string loose =
            join(R"({"attributes":{"POSITION":0},"indices":7,"mode":)", mode, "}");
        for (const std::string& both : {loose + "," + triangles, triangles + "," + loose}) {
            const MeshFileContent content =
                read("x.glb", glb_of(replaced(glb_json, triangles, both), glb_buffer));
            ASSERT_EQ(content.meshes.size(), 3U);
            EXPECT_EQ(content.meshes[1].points.rows(), 4);
            EXPECT_EQ(content.meshes[1].faces, halves);
        }
        const std::string alone = replaced(glb_json, triangles, loose);
        EXPECT_NE(refusal("x.glb", glb_of(alone, glb_buffer)).find("points and lines alone"),
                  std::string::npos);
        // A curve that another node shows.
        std::string scene = replaced(glb_json, R"({"mesh":0,"scale":[2,2,2]}])",
                                     R"({"mesh":0,"name":"skin"},{"mesh":1,"name":"curve"}])");
        scene = replaced(scene, R"({"nodes":[0]})", R"({"nodes":[2,0]})");
        scene = replaced(scene, R"(["smile","smile"]}}])",
                         join(R"(["smile","smile"]}},{"primitives":[)", loose, "]}]"));
        const MeshFileContent content = read("x.glb", glb_of(scene, glb_buffer));
        ASSERT_EQ(content.meshes.size(), 3U);
        EXPECT_EQ(content.meshes[0].name, "x");
    }
    const std::string strip = replaced(triangles, "\"indices\"", "\"mode\":5,\"indices\"");
    EXPECT_NE(
        refusal("x.glb", glb_of(replaced(glb_json, triangles, triangles + "," + strip), glb_buffer))
            .find("export single triangles"),
        std::string::npos);
}

TEST(GlbFile, NormalisesRotationsThatAreNearlyUnitAndRefusesWhatBendsTheMesh)
{
    const std::string place = R"("scale":[2,2,2])";
    const auto with = [&](const std::string& other) {
        return glb_of(replaced(glb_json, place, other), glb_buffer);
    };
    Points turned = square;
    turned.col(0) = 10.0 - square.col(1).array();
    turned.col(1) = square.col(0);
    for (const char* rotation :
         {R"("rotation":[0,0,0.70710678,0.70710678])", R"("rotation":[0,0,0.703,0.703])",
          R"("rotation":[0,0,0.709,0.709])"})
        EXPECT_LT((read("x.glb", with(rotation)).meshes[0].points - turned).norm(), 1e-7)
            << rotation;
    for (const char* rotation :
         {R"("rotation":[0,0,2,2])", R"("rotation":[0,0,0,0])", R"("rotation":[0,0,0.69,0.69])",
          R"("rotation":[0,0,1e200,1e200])"})
        EXPECT_NE(refusal("x.glb", with(rotation)).find("must be 1 (a unit quaternion)"),
                  std::string::npos)
            << rotation;
    for (const char* flat : {R"("scale":[0,1,1])", R"("scale":[1,0,0])", R"("scale":[1,1,1e-7])",
                             R"("scale":[1,-1e-4,1])", R"("scale":[1000,1000,0.05])",
                             R"("rotation":[0.5,0.5,0.5,0.5],"scale":[1,0,1])",
                             R"("matrix":[1,0,0,0,0,1,0,0,0,0,0,0,0,0,0,1])",
                             R"("matrix":[1,1,0,0,1,1,0,0,0,0,1,0,0,0,0,1])"})
        EXPECT_NE(refusal("x.glb", with(flat)).find("flattens it"), std::string::npos) << flat;
    for (const char* nothing :
         {R"("scale":[0,0,0])", R"("scale":[1e-12,1e-12,1e-12])",
          R"("scale":[1e-200,1e-200,1e-200])", R"("matrix":[0,0,0,0,0,0,0,0,0,0,0,0,0,0,0,1])"})
        EXPECT_NE(refusal("x.glb", with(nothing)).find("shrinks it to nothing"), std::string::npos)
            << nothing;
    // Units are uniform; a relief may be low.
    for (const char* other :
         {R"("scale":[1e-9,1e-9,1e-9])", R"("scale":[1e9,1e9,1e9])", R"("scale":[1,1,0.001])"})
        EXPECT_EQ(read("x.glb", with(other)).meshes[0].points.rows(), 4) << other;
    // Which of both holds, glTF leaves open.
    for (const char* both : {"translation\":[0,0,0]", "rotation\":[0,0,0,1]", "scale\":[1,1,1]"}) {
        const std::string said =
            refusal("x.glb", with(join(R"("matrix":[1,0,0,0,0,1,0,0,0,0,1,0,0,0,0,1],")", both)));
        const std::string_view name =
            std::string_view(both).substr(0, std::string_view(both).find('"'));
        EXPECT_NE(said.find(join("both 'matrix' and '", name, "'")), std::string::npos) << said;
    }
    EXPECT_NE(refusal("x.glb", with(R"("matrix":[1,0,0,0.1,0,1,0,0,0,0,1,0,0,0,0,1])"))
                  .find("no perspective"),
              std::string::npos);
    EXPECT_NE(refusal("x.glb", with(R"("matrix":[1,0,0,0,0,1,0,0,0,0,1,0,0,0,0,2])"))
                  .find("no perspective"),
              std::string::npos);
    EXPECT_EQ(read("x.glb", with(R"("matrix":[1,0,0,0,0,1,0,0,0,0,1,0,0,0,0,1])"))
                  .meshes[0]
                  .points.col(1),
              square.col(1));
}

TEST(GlbFile, TakesTenThousandMeshesInAllAndNoMore)
{
    // Three members a node, all of one name.
    const auto file_of = [](int nodes) {
        std::string list;
        std::string places;
        for (int i = 0; i < nodes; ++i) {
            list += join(i == 0 ? "" : ",", R"({"mesh":0,"name":"a"})");
            places += join(i == 0 ? "" : ",", i);
        }
        std::string json =
            replaced(glb_json,
                     R"({"children":[1],"translation":[10,0,0]},{"mesh":0,"scale":[2,2,2]})", list);
        json = replaced(json, R"("scenes":[{"nodes":[0]}])",
                        join(R"("scenes":[{"nodes":[)", places, "]}]"));
        json.resize((json.size() + 3) / 4 * 4, ' ');
        return glb_of(json, glb_buffer);
    };
    const MeshFileContent content = read("n.glb", file_of(3333));
    ASSERT_EQ(content.meshes.size(), 9999U);
    EXPECT_EQ(content.meshes[0].name, "n_a");
    EXPECT_EQ(content.meshes[9996].name, "n_a (3333)");
    EXPECT_NE(test::message_of<LimitExceeded>([&] {
                  (void)read("n.glb", file_of(3334));
              }).find("more than 10000 meshes"),
              std::string::npos);
}

TEST(GlbFile, UsesWhatItHoldsAsOftenAsALimitOrItsBufferAllows)
{
    // A node makes three meshes of four vertices from a buffer of 68 bytes and more.
    const auto refusal_of = [](int nodes, std::size_t buffer, std::int64_t rows) -> std::string {
        std::string json = replaced(glb_json, R"({"children":[1])", R"({"children":[1,2])");
        json = replaced(json, R"(,{"mesh":0,)", R"(,{"mesh":0},{"mesh":0,)");
        if (nodes == 1)
            json = glb_json;
        std::string bytes = glb_buffer;
        bytes.resize(buffer);
        try {
            (void)parse_glb(glb_of(json, bytes), "a.glb", {}, {.rows = rows});
            return "";
        } catch (const LimitExceeded& error) {
            return error.what();
        }
    };
    EXPECT_EQ(refusal_of(1, 68, 12), "");
    EXPECT_NE(refusal_of(1, 68, 11).find("3 meshes of 4 vertices; the limit is 11"),
              std::string::npos);
    EXPECT_EQ(refusal_of(1, 144, 0), "");
    EXPECT_NE(refusal_of(1, 140, 0).find("the limit is 11 vertices"), std::string::npos);
    EXPECT_EQ(refusal_of(2, 68, 24), "");
    EXPECT_NE(refusal_of(2, 68, 23).find("place more than 23 vertices"), std::string::npos);
    EXPECT_EQ(refusal_of(2, 144, 12), "");
    EXPECT_NE(refusal_of(2, 140, 12).find("place more than 23 vertices"), std::string::npos);
}

TEST(GlbFile, RefusesInALineWhatItDoesNotHold)
{
    for (const auto& [what, by, rule] : std::vector<std::array<std::string, 3>>{
             {"\"count\":4", "\"count\":400000", "does not hold"},
             {"\"count\":4", "\"count\":-1", "'count' is -1"},
             {"\"count\":4", "\"count\":1e300", "no integer"},
             // Beyond 63 bits: what stands in the file.
             {"\"byteOffset\":48", "\"byteOffset\":9223372036854775808",
              "'byteOffset' is 9223372036854775808, must be in [0, 1099511627776]"},
             {"\"count\":4", "\"count\":18446744073709551615", "'count' is 18446744073709551615"},
             {"\"children\":[1]", "\"children\":[18446744073709551615]",
              "a node is referred to by '18446744073709551615'"},
             {"\"children\":[1]", "\"children\":[0]", "met twice"},
             {"\"children\":[1]", "\"children\":[7]", "no entry 7 of nodes"},
             {"\"indices\":1", "\"mode\":5", "mode 5"},
             {"\"mesh\":0", "\"mesh\":1", "no entry 1 of meshes"},
             {"\"mesh\":0,", "", "no node of the scene"},
             {"\"byteOffset\":48", "\"byteOffset\":4800", "outside the file"},
             {"{\"byteLength\":68}", "{\"byteLength\":68,\"uri\":\"a.bin\"}", "another file"},
             {"\"count\":1", "\"count\":5", "sparse"},
             {"5121", "5126", "indices have the componentType 5126"},
             {"\"bufferView\":1,", "", "no bufferView"},
             {"\"version\":\"2.0\"", "\"version\":\"1.0\"", "must be 2.0"},
             {"\"scene\":0", "\"extensionsRequired\":[\"EXT_meshopt_compression\"]",
              "without compression"},
             {"\"scene\":0", "\"extensionsUsed\":[\"EXT_mesh_gpu_instancing\"]",
              "shows copies of a mesh"},
             {"\"scene\":0", "\"extensionsRequired\":[\"ACME_folded_meshes\"]",
              "'ACME_folded_meshes'"},
             {"\"scene\":0",
              "\"scene\":0,\"extras\":" + std::string(5000, '[') + std::string(5000, ']'),
              "deeper than 64 levels"},
             {"\"asset\"", "asset", "damaged"}}) {
        const std::string message =
            refusal("a.glb", glb_of(replaced(glb_json, what, by), glb_buffer));
        EXPECT_NE(message.find(rule), std::string::npos) << message << " for " << by;
    }
    EXPECT_NE(refusal("a.glb", "glTF").find("GLB file?"), std::string::npos);
    const std::string far = replaced(glb_json, "\"targets\":[{\"POSITION\":2},", "\"targets\":[");
    EXPECT_EQ(read("b.glb", glb_of(far, glb_buffer)).meshes.size(), 2U);
    const std::string textured =
        replaced(glb_json, "\"scene\":0", "\"extensionsRequired\":[\"KHR_texture_basisu\"]");
    EXPECT_EQ(read("c.glb", glb_of(textured, glb_buffer)).meshes.size(), 3U);
    const std::string nameless = replaced(glb_json, "targetNames", "names");
    EXPECT_EQ(read("d.glb", glb_of(nameless, glb_buffer)).meshes[2].name, "d_target_2");
}

TEST(MeshFormats, TakeNoHarmFromDamage)
{
    const TemporaryDirectory directory;
    const TestMesh mesh = test::tetrahedron();
    std::vector<std::pair<std::string, std::string>> files{
        {"a.stl", stl_text}, {"a.vtp", vtp_text}, {"a.glb", glb_of(glb_json, glb_buffer)}};
    for (const char* name : {"b.stl", "b.vtk", "b.vtp", "b.glb"}) {
        write_mesh(directory / name, mesh.points, mesh.topology.faces());
        files.emplace_back(name, test::read_bytes(directory / name));
    }
    Random random(3);
    std::size_t refused = 0;
    const auto attempt = [&](const std::string& name, std::string_view bytes) {
        try {
            (void)read(name, bytes, true);
        } catch (const InvalidInput& error) {
            EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos) << error.what();
            ++refused;
        } catch (const LimitExceeded&) {
            ++refused;
        }
    };
    for (const auto& [name, bytes] : files) {
        for (std::size_t length = 0; length < bytes.size(); length += 1 + bytes.size() / 200)
            attempt(name, std::string_view(bytes).substr(0, length));
        for (int round = 0; round < 200; ++round) {
            std::string damaged = bytes;
            for (int hit = 0; hit < 1 + round % 3; ++hit)
                damaged[random.bits() % damaged.size()] = static_cast<char>(random.bits());
            attempt(name, damaged);
        }
    }
    EXPECT_GT(refused, 1000U);
}

} // namespace
} // namespace shape
