// SPDX-License-Identifier: MIT

#include "libshape/io/mesh_file.h"

#include <gtest/gtest.h>
#include <sys/stat.h>
#include <sys/types.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <bit>
#include <clocale>
#include <cmath>
#include <cstring>
#include <limits>
#include <memory>
#include <utility>

#include "libshape/base/error.h"
#include "libshape/base/format.h"
#include "libshape/base/random.h"
#include "libshape/base/to_size.h"
#include "libshape/io/mesh_write_options.h"
#include "libshape/io/obj_template.h"
#include "tests/support/files.h"
#include "tests/support/meshes.h"

namespace shape {
using namespace internal;
namespace {

using namespace std::string_view_literals;

NamedMesh read(const std::string& name, std::string_view content, bool triangulate = false)
{
    static const test::TemporaryDirectory directory;
    test::write_bytes(directory / name, content);
    return read_mesh(directory / name, {.triangulate = triangulate});
}

/// Equal bits, so that -0.0 differs from 0.0.
bool same_bits(const Points& a, const Points& b)
{
    return a.rows() == b.rows() && std::memcmp(a.data(), b.data(), to_size(a.size()) * 8) == 0;
}

/// Coordinates that are hard to print: every magnitude, denormals, signed zeros.
Points hard_points(Eigen::Index count)
{
    Random random(7);
    Points points(count, 3);
    for (double& value : points.reshaped())
        do
            value = std::bit_cast<double>(random.bits());
        while (!std::isfinite(value));
    points.row(0) << 0.0, -0.0, std::numeric_limits<double>::denorm_min();
    points.row(1) << std::numeric_limits<double>::max(), std::numeric_limits<double>::min(), 1e22;
    points.row(2) << 0.1, 1.0 / 3.0, -123456789.12345678;
    return points;
}

/// Appends a value as a PLY scalar type, in either order of bytes.
template <class Stored>
void append_scalar(std::string& bytes, double value, bool big_endian)
{
    const auto stored = static_cast<Stored>(value);
    std::string part(sizeof(Stored), '\0');
    std::memcpy(part.data(), &stored, sizeof(Stored));
    if (big_endian)
        std::reverse(part.begin(), part.end());
    bytes += part;
}

void append_scalar(std::string& bytes, const std::string& type, double value, bool big_endian)
{
    if (type == "char" || type == "int8")
        append_scalar<std::int8_t>(bytes, value, big_endian);
    else if (type == "uchar" || type == "uint8")
        append_scalar<std::uint8_t>(bytes, value, big_endian);
    else if (type == "short" || type == "int16")
        append_scalar<std::int16_t>(bytes, value, big_endian);
    else if (type == "ushort" || type == "uint16")
        append_scalar<std::uint16_t>(bytes, value, big_endian);
    else if (type == "int" || type == "int32")
        append_scalar<std::int32_t>(bytes, value, big_endian);
    else if (type == "uint" || type == "uint32")
        append_scalar<std::uint32_t>(bytes, value, big_endian);
    else if (type == "float" || type == "float32")
        append_scalar<float>(bytes, value, big_endian);
    else if (type == "int64" || type == "long")
        append_scalar<std::int64_t>(bytes, value, big_endian);
    else if (type == "uint64" || type == "ulong")
        append_scalar<std::uint64_t>(bytes, value, big_endian);
    else if (type == "float16" || type == "half") // of 0 and 1
        append_scalar<std::uint16_t>(bytes, value == 0.0 ? 0.0 : 0x3c00, big_endian);
    else
        append_scalar<double>(bytes, value, big_endian);
}

const std::vector<std::string> integer_types = {
    "char",  "uchar",  "short", "ushort", "int",   "uint",   "int8", "uint8",
    "int16", "uint16", "int32", "uint32", "int64", "uint64", "long", "ulong"};

const char* const ply_header =
    "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\n"
    "property float y\nproperty float z\nelement face 1\n"
    "property list uchar int vertex_indices\nend_header\n";

const char* const binary_header =
    "ply\nformat binary_little_endian 1.0\nelement vertex 3\nproperty float x\n"
    "property float y\nproperty float z\nelement face 1\n"
    "property list uchar int vertex_indices\nend_header\n";

void expect_unit_triangle(const NamedMesh& mesh)
{
    ASSERT_EQ(mesh.points.rows(), 3);
    ASSERT_EQ(mesh.faces.rows(), 1);
    EXPECT_EQ(mesh.points, (Points(3, 3) << 0, 0, 0, 1, 0, 0, 0, 1, 0).finished());
    EXPECT_EQ(mesh.faces, (Faces(1, 3) << 0, 1, 2).finished());
}

TEST(MeshFile, PrintsIntegersBeyond63BitsAsTheyStandInTheFile)
{
    std::string bytes =
        "ply\nformat binary_little_endian 1.0\nelement vertex 3\nproperty float x\n"
        "property float y\nproperty float z\nelement face 1\n"
        "property list uchar uint64 vertex_indices\nend_header\n";
    for (const double x : {0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0})
        append_scalar<float>(bytes, x, false);
    bytes += '\3';
    bytes += std::string(16, '\0') + std::string(7, '\0') + '\x80';
    const std::string message = test::message_of<InvalidInput>([&] { (void)read("a.ply", bytes); });
    EXPECT_NE(
        message.find("an integer is 9223372036854775808, which is beyond what can be counted"),
        std::string::npos)
        << message;
}

TEST(MeshFile, GivesEveryBitAndTheOrderBackInEveryFormat)
{
    const test::TemporaryDirectory directory;
    const test::TestMesh sphere = test::icosphere(2);
    const Points points = hard_points(sphere.points.rows());
    for (const MeshFormat format :
         {MeshFormat::Obj, MeshFormat::Ply, MeshFormat::Off, MeshFormat::Vtk}) {
        const std::filesystem::path path = directory / ("some.mesh" + file_ending(format));
        SCOPED_TRACE(path);
        write_mesh(path, points, sphere.topology.faces(), format);
        const NamedMesh mesh = read_mesh(path);
        EXPECT_EQ(mesh.name, "some.mesh");
        EXPECT_EQ(mesh.path, path.string());
        EXPECT_TRUE(same_bits(mesh.points, points));
        EXPECT_EQ(mesh.faces, sphere.topology.faces());
    }
    EXPECT_EQ(directory.names().size(), 4u);
}

TEST(MeshFile, RefusesToWriteWhatCannotBeReadAgain)
{
    const test::TemporaryDirectory directory;
    const test::TestMesh mesh = test::tetrahedron();
    Points points = mesh.points;
    points(2, 1) = std::numeric_limits<double>::quiet_NaN();
    const auto message = [&](const Points& p, const Faces& f) {
        return test::message_of<InvalidInput>(
            [&] { write_mesh(directory / "m.ply", p, f, MeshFormat::Ply); });
    };
    EXPECT_NE(message(points, mesh.topology.faces()).find("row 2"), std::string::npos);
    Faces faces = mesh.topology.faces();
    faces(1, 2) = 4;
    EXPECT_NE(message(mesh.points, faces).find("row 1"), std::string::npos);
    EXPECT_TRUE(directory.names().empty());
}

TEST(MeshFile, TakesItsFormatFromTheEndingInAnyCase)
{
    EXPECT_EQ(mesh_format("a.OBJ"), MeshFormat::Obj);
    EXPECT_EQ(mesh_format("a.b.Ply"), MeshFormat::Ply);
    EXPECT_EQ(mesh_format("dir.obj/a.off"), MeshFormat::Off);
    EXPECT_EQ(mesh_format(".off"), MeshFormat::Off);
    EXPECT_EQ(mesh_format("a.glb"), MeshFormat::Glb);
    for (const char* name : {"a.fbx", "a", "obj", "a.obj.gz", "a.obj ", ""}) {
        const std::string message =
            test::message_of<InvalidInput>([&] { (void)mesh_format(name); });
        EXPECT_NE(message.find(".obj, .ply, .off, .stl, .vtk, .vtp or .glb"), std::string::npos)
            << message;
    }
}

TEST(ObjFile, ReadsReferencesOfEveryKindAndIgnoresMaterials)
{
    for (const char* text : {
             "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n",
             "v 0 0 0\r\nv 1 0 0\r\nv 0 1 0\r\nf 1 2 3\r\n",
             "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3",
             "# made by hand\n\n  v\t0 0 0 \nv +1.0 0e0 -0.0e-3\nv 0 1 0 # last\nf -3 -2 -1\n",
             "mtllib ../../etc/passwd\no thing\ng a b\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl m\ns off\n"
             "f 1 2 3\nl 1 2\np 1\n",
             "v 0 0 0 1.0\nv 1 0 0 0.5 0.5 0.5\nv 0 1 0 1 0 0 0\nf 1 2 3\n",
             "v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 0 0\nvn 0 0 1\nf 1/1 2/2 3/1\n",
             "v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvn 0 0 1\nf 1/1/1 2/-1/-1 3/1/1\n",
             "v 0 0 0\nv 1 0 0\nv 0 1 0\nvn 0 0 1\nf 1//1 2//1 3//-1\n",
             // References that are empty, lead nowhere, or to what is not read.
             "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1// 2// 3//\n",
             "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1/ 2/ 3/\n",
             "v 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nf 1/1/ 2/1/ 3/1/\n",
             "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1/7/9 2/0/0 3/-5/-6\n",
             "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1//99999999999999999999 2//1 3//1\n",
             "v 0 0 0\nv 1 0 0\nv 0 1 0\nvn nan nan nan\nvn 0 1\nvt -nan(ind) inf\nvt\nvt a b\n"
             "vp 1\nvc 1 0 0\nl 1/ 2\nf 1//1 2//1 3//1\n",
             // Colours: three or four numbers, kept by nobody.
             "v 0 0 0 0.2 0.4 0.6 0.8\nv 1 0 0 1 2 3 4 5\nv 0 1 0 nan nan nan\nf 1 2 3\n",
             "v 0 0 0 1e999 0 0\nv 1 0 0 .5 .5\nv 0 1 0\nf 1 2 3\n",
             // Continued lines; a backslash at the end of a name or a comment continues nothing.
             "v 0 0 \\\n0\nv \\\n 1 \\\r\n 0 \\  \n 0\nv 0 1 0\nf 1 \\\n2 3\n",
             "mtllib C:\\models\\\nv 0 0 0\nusemtl a\\\nv 1 0 0\n# D:\\\nv 0 1 0\no b\\\nf 1 2 3\n",
             "v 0 0 0\nv 1 0 0\nv 0 1 0\ng one \\\n two three\nl 1 \\\n2\nf 1 2 3\\",
             "\xEF\xBB\xBFv 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n",
             "v 0 0 0\rv 1 0 0\rv 0 1 0\rf 1 2 3\r",
             "v 0 0 0   \nv 1 0 0\t\nv 0 1 0 \r\n   \nf 1 2 3  \n",
         }) {
        SCOPED_TRACE(text);
        const NamedMesh mesh = read("m.obj", text);
        EXPECT_EQ(mesh.name, "m");
        expect_unit_triangle(mesh);
    }
}

TEST(OffFile, ReadsCountsOnEitherLineCommentsAndColours)
{
    for (const char* text : {
             "OFF\n3 1 3\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n",
             "OFF\n3 1\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2",
             "OFF 3 1 0\r\n0 0 0\r\n1 0 0\r\n0 1 0\r\n3 0 1 2\r\n",
             "# c\nOFF # c\n# c\n\n3 1 0 # c\n\n0 0 0\n# c\n1 0 0\n0 1 0\n3 0 1 2 255 0 0 # c\n# "
             "c\n",
             "OFF3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n",
             "3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n",
             "OFF3 1\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n",
             "COFF\n3 1 0\n0 0 0 255 0 0 255\n1 0 0 .1 .2 .3\n0 1 0 0 0 0 0\n3 0 1 2\n",
             "NOFF 3 1 0\n0 0 0 0 0 1\n1 0 0 nan nan nan\n0 1 0 0 0 1\n3 0 1 2\n",
             "CNOFF\n3 1 0\n0 0 0 1 1 1 1 0 0 1\n1 0 0 1 1 1 0 0 1\n0 1 0 1 1 1 0 0 1\n3 0 1 2\n",
             "STOFF\n3 1 0\n0 0 0 0 0\n1 0 0 1 0\n0 1 0 0 1\n3 0 1 2 0.5\n",
             "\xEF\xBB\xBFOFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n",
             "OFF  \n3 1 0 \n0 0 0 \n1 0 0\t\n0 1 0\n3 0 1 2 \n",
             "OFF\r3 1 0\r0 0 0\r1 0 0\r0 1 0\r3 0 1 2\r",
             "off\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n",
             "Off3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n",
             "coff\n3 1 0\n0 0 0 255 0 0\n1 0 0 9 9 9\n0 1 0 9 9 9\n3 0 1 2\n",
         }) {
        SCOPED_TRACE(text);
        expect_unit_triangle(read("m.off", text));
    }
}

TEST(OffFile, ReadsNumbersThatRunOnOverTheLines)
{
    for (const char* text :
         {"OFF 3 1 0 0 0 0 1 0 0 0 1 0 3 0 1 2", // all on one line
          "OFF\n3\n1\n0\n0\n0\n0\n1\n0\n0\n0\n1\n0\n3\n0\n1\n2\n",
          "OFF\n3 1 0 0 0 0 1 0 0 0 1 0\n3 0 1 2 255 0 0\n",
          "OFF\n3 1 0\n0 0 0 1 0 0\n0 1 0\n3 0 1 2\n",
          "OFF\n3 1 0\n0 0\n0 1 0 0 0\n1 0\n3 0 1\n2\n",
          "OFF # c\n3 # c\n1 # c\n0\n0 0 0 # c\n# c\n1 0 0 0 1 0\n3 0 # c\n1 2\n",
          "OFF 3\n1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n",
          "OFF\n3 1\n0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n", // edges alone
          "COFF\n3 1 0\n0 0 0 9 9 9 9 1 0 0 9 9 9 9 0 1 0 9 9 9 9\n3 0 1 2\n",
          "COFF\n3 1 0\n0 0 0\n9 9 9 9\n1 0 0\n9 9 9 9\n0 1 0\n9 9 9 9\n3 0 1 2\n",
          "NOFF 3 1 0 0 0 0 0 0 1 1 0 0 nan nan nan 0 1 0 0 0 1 3 0 1 2\n"}) {
        SCOPED_TRACE(text);
        expect_unit_triangle(read("m.off", text));
    }
    // A line of very many vertices is looked at once for each, not once for each pair.
    std::string line = "COFF 60000 1 0";
    for (int v = 0; v < 60000; ++v)
        line += v % 3 == 0 ? " 0 0 0 1 1 1 1" : v % 3 == 1 ? " 1 0 0 1 1 1 1" : " 0 1 0 1 1 1 1";
    EXPECT_EQ(read("m.off", line + "\n3 0 1 2\n").points.rows(), 60000);
}

TEST(OffFile, ColoursOfVerticesUnderAPlainHeaderAreNamed)
{
    for (const char* text :
         {"OFF\n4 2 0\n0 0 0 255 0 0\n1 0 0 .5 0 0\n0 1 0 -.5 0 0\n0 0 1 -.5 0 0\n3 0 1 2\n3 0 1 "
          "3\n",
          "OFF\n4 1 0\n0 0 0 255 0 0\n1 0 0 9 0 0\n0 1 0 3 -.5 0\n3 0 -.5 3 0 0\n3 0 1 2\n"}) {
        const std::string said = test::message_of<InvalidInput>([&] { (void)read("m.off", text); });
        EXPECT_NE(said.find("line 3: "), std::string::npos) << said;
        EXPECT_NE(said.find("colours need the header COFF"), std::string::npos) << said;
    }
}

TEST(PlyFile, ReadsFacesThatStandBeforeTheirVertices)
{
    expect_unit_triangle(
        read("m.ply",
             "ply\nformat ascii 1.0\nelement face 1\nproperty list uchar int vertex_indices\n"
             "element vertex 3\nproperty float x\nproperty float y\nproperty float z\n"
             "end_header\n3 0 1 2\n0 0 0\n1 0 0\n0 1 0\n"));
}

TEST(PlyFile, ReadsAsciiWithExtraPropertiesAndElements)
{
    expect_unit_triangle(read("m.ply", std::string(ply_header) + "0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n"));
    expect_unit_triangle(
        read("m.ply",
             "ply\r\nformat ascii 1.0\r\ncomment by hand\r\nobj_info none\r\n"
             "element camera 2\r\nproperty float f\r\n"
             "element vertex 3\r\nproperty double z\r\nproperty uchar red\r\n"
             "property float y\r\nproperty list uchar float weights\r\n"
             "property int x\r\nelement face 1\r\nproperty uchar flag\r\n"
             "property list uint uint vertex_index\r\nproperty list uchar float uv\r\n"
             "element edge 1\r\nproperty int a\r\nproperty int b\r\nend_header\r\n"
             "0.5\r\n0.25\r\n0 255 0 0 0\r\n0 0 0 2 .5 .5 1\r\n0 7 1 1 1 0\r\n"
             "9 3 0 1 2 6 0 0 1 0 0 1\r\n0 1\r\n\r\n"));
}

/// The unit triangle with these types, among properties and elements to be skipped.
std::string binary_ply(const std::string& coordinate, const std::string& count,
                       const std::string& index, bool big_endian)
{
    std::string bytes = join("ply\nformat binary_", big_endian ? "big" : "little",
                             "_endian 1.0\nelement vertex 3\nproperty ", coordinate,
                             " x\nproperty short skipped\nproperty ", coordinate, " y\nproperty ",
                             coordinate, " z\nproperty list ", count, " double more\n",
                             "element other 2\nproperty uchar c\nelement face 1\nproperty list ",
                             count, " ", index, " vertex_indices\nproperty float q\nend_header\n");
    const auto add = [&](const std::string& type, double value) {
        append_scalar(bytes, type, value, big_endian);
    };
    for (const auto& p : {std::array{0, 0, 0}, {1, 0, 0}, {0, 1, 0}}) {
        add(coordinate, p[0]);
        add("short", 9);
        add(coordinate, p[1]);
        add(coordinate, p[2]);
        add(count, p[0]);
        for (int i = 0; i < p[0]; ++i)
            add("double", 0.5);
    }
    add("uchar", 1);
    add("uchar", 2);
    add(count, 3);
    for (const int v : {0, 1, 2})
        add(index, v);
    add("float", 1.5);
    return bytes;
}

TEST(PlyFile, ReadsEveryScalarTypeInBothOrdersOfBytes)
{
    std::vector<std::string> all_types = integer_types;
    all_types.insert(all_types.end(), {"float", "double", "float32", "float64", "float16", "half"});
    for (const bool big_endian : {false, true}) {
        for (const std::string& type : all_types)
            expect_unit_triangle(read("m.ply", binary_ply(type, "uchar", "int", big_endian)));
        for (const std::string& type : integer_types) {
            expect_unit_triangle(read("m.ply", binary_ply("float", type, "int", big_endian)));
            expect_unit_triangle(read("m.ply", binary_ply("float", "uchar", type, big_endian)));
        }
    }
}

TEST(PlyFile, ReadsHeadersAsLooseAsTheyCome)
{
    const std::string rest =
        "element vertex 3 \nproperty float x\t\nproperty float y\nproperty float z\nproperty half "
        "q\n"
        "element face 1\nproperty list uchar long vertex_indices\nend_header  \n";
    const std::string body = "0 0 0 1 \n1 0 0 nan\n0 1 0 -inf\n3 0 1 2  \n";
    for (const std::string start :
         {"ply\ncomment first\nobj_info second\nformat ascii 1.0\n", "ply \nformat ascii 1.0 \n",
          "\xEF\xBB\xBFply\n\ncomment\nformat ascii 1.0\ncomment C:\\models\\\n"})
        expect_unit_triangle(read("m.ply", start + rest + body));
    // As templates of exporters declare it, empty.
    expect_unit_triangle(read("m.ply",
                              "ply\nformat ascii 1.0\nelement tristrips 0\n"
                              "property list int int vertex_indices\n" +
                                  rest + body));
    std::string old_mac = "ply\nformat ascii 1.0\n" + rest + body;
    std::replace(old_mac.begin(), old_mac.end(), '\n', '\r');
    expect_unit_triangle(read("m.ply", old_mac));

    std::string binary = binary_ply("float", "uchar", "int", false);
    binary.replace(binary.find("end_header"), 10, "comment x\nend_header \t");
    expect_unit_triangle(read("m.ply", binary));
    expect_unit_triangle(read("m.ply", binary + "\n"));
}

TEST(PlyFile, ReadsHalvesAsTheirDefinitionSays)
{
    // Sign, exponent, mantissa: IEEE 754-2008, binary16.
    const std::vector<std::pair<int, double>> known = {
        {0x3c00, 1.0},        {0xc000, -2.0},    {0x7bff, 65504.0},
        {0x0400, 0x1p-14},    {0x0001, 0x1p-24}, {0x03ff, 1023 * 0x1p-24},
        {0x3555, 0x1.554p-2}, {0x8000, -0.0},    {0x3c01, 1 + 0x1p-10}};
    for (const auto& [bits, value] : known) {
        std::string bytes =
            "ply\nformat binary_little_endian 1.0\nelement vertex 3\nproperty half x\nproperty "
            "half y\nproperty half z\nelement face 1\nproperty list uchar int vertex_indices\n"
            "end_header\n";
        append_scalar<std::uint16_t>(bytes, bits, false);
        bytes += std::string(16, '\0') + '\3';
        for (const int v : {0, 1, 2})
            append_scalar<std::int32_t>(bytes, v, false);
        const Points points = read("m.ply", bytes).points;
        EXPECT_EQ(points(0, 0), value);
        EXPECT_EQ(std::signbit(points(0, 0)), std::signbit(value));
        bytes.replace(bytes.size() - 31, 2, std::string("\x00\x7c", 2)); // infinite
        EXPECT_THROW((void)read("m.ply", bytes), InvalidInput);
    }
}

TEST(PlyFile, KeepsDoublesOfBothOrdersOfBytes)
{
    const Points points = hard_points(3);
    for (const bool big_endian : {false, true}) {
        std::string bytes =
            join("ply\nformat binary_", big_endian ? "big" : "little",
                 "_endian 1.0\nelement vertex 3\nproperty double x\nproperty double "
                 "y\nproperty double z\nelement face 1\nproperty list uchar uint "
                 "vertex_indices\nend_header\n");
        for (const double value : points.reshaped<Eigen::RowMajor>())
            append_scalar<double>(bytes, value, big_endian);
        append_scalar<std::uint8_t>(bytes, 3, big_endian);
        for (const int v : {2, 0, 1})
            append_scalar<std::uint32_t>(bytes, v, big_endian);
        const NamedMesh mesh = read("m.ply", bytes);
        EXPECT_TRUE(same_bits(mesh.points, points));
        EXPECT_EQ(mesh.faces, (Faces(1, 3) << 2, 0, 1).finished());
    }
}

TEST(MeshFile, SplitsPolygonsAsFansIfAsked)
{
    const Faces fan = (Faces(3, 3) << 4, 0, 1, 4, 1, 2, 4, 2, 3).finished();
    const std::string points = "0 0 0\n1 0 0\n1 1 0\n0 1 0\n-1 0.5 0\n";
    EXPECT_EQ(read("m.off", "OFF\n5 1 0\n" + points + "5 4 0 1 2 3\n", true).faces, fan);
    EXPECT_EQ(read("m.ply",
                   "ply\nformat ascii 1.0\nelement vertex 5\nproperty float x\nproperty float y\n"
                   "property float z\nelement face 1\nproperty list uchar int vertex_indices\n"
                   "end_header\n" +
                       points + "5 4 0 1 2 3\n",
                   true)
                  .faces,
              fan);
    EXPECT_EQ(
        read("m.obj", "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv -1 0.5 0\nf -1 1 2 3 4\n", true).faces,
        fan);
}

TEST(MeshFile, ReadsIndependentlyOfTheLocale)
{
    const char* before = std::setlocale(LC_ALL, nullptr);
    const std::string saved = before == nullptr ? "C" : before;
    if (std::setlocale(LC_ALL, "de_DE.UTF-8") == nullptr)
        GTEST_SKIP() << "no locale with a decimal comma is installed";
    const NamedMesh mesh = read("m.obj", "v 0.5 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n");
    std::setlocale(LC_ALL, saved.c_str());
    EXPECT_EQ(mesh.points(0, 0), 0.5);
}

/// One malformed file: what the message must say about place and rule.
struct BadFile
{
    std::string name;
    std::string content;
    std::string place;
    std::string rule;
};

std::string ascii_ply(const std::string& body)
{
    return ply_header + body;
}

std::vector<BadFile> bad_files()
{
    const std::string obj = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";
    const std::string long_line(std::size_t{2} << 20, ' ');
    const auto off_counts = [](const std::string& counts) {
        return "OFF\n" + counts + "\n0 0 0\n";
    };
    const auto ply_counts = [](const std::string& vertices, const std::string& faces) {
        return "ply\nformat ascii 1.0\nelement vertex " + vertices +
               "\nproperty float x\nproperty float y\nproperty float z\nelement face " + faces +
               "\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 "
               "2\n";
    };
    std::string binary = binary_header;
    for (const double value : {0, 0, 0, 1, 0, 0, 0, 1, 0})
        append_scalar<float>(binary, value, false);
    const std::string binary_points = binary;
    const auto binary_face = [&](int count, std::vector<std::int32_t> corners) {
        std::string bytes = binary_points + static_cast<char>(count);
        for (const std::int32_t v : corners)
            append_scalar<std::int32_t>(bytes, v, false);
        return bytes;
    };
    std::string binary_nan = binary_points;
    const float nan = std::numeric_limits<float>::quiet_NaN();
    std::memcpy(binary_nan.data() + binary_nan.size() - 4, &nan, 4);

    std::vector<BadFile> files = {
        // Nothing in it.
        {"a.obj", "", "a.obj", "empty"},
        {"a.ply", "", "a.ply", "empty"},
        {"a.off", "", "a.off", "empty"},
        {"a.obj", "# only this\n", "a.obj", "0 vertices and 0 faces"},
        {"a.obj", obj, "a.obj", "3 vertices and 0 faces"},
        {"a.off", "OFF\n1 0 0\n0 0 0\n", "a.off", "1 vertex and 0 faces"},
        {"a.off", "# only this\n", "a.off", "nothing but comments"},
        {"a.obj", "f 1 2 3\n" + obj, "line 1", "must be in [1, 0]"},
        // Indices.
        {"a.obj", obj + "f 0 1 2\n", "line 4", "vertex index is 0"},
        {"a.obj", obj + "f 1 2 4\n", "line 4", "vertex index is 4"},
        {"a.obj", obj + "f 1 2 -4\n", "line 4", "vertex index is -4"},
        {"a.obj", obj + "f 1 2 2147483648\n", "line 4", "2147483648"},
        {"a.obj", obj + "f 1 2 99999999999999999999\n", "line 4",
         "'99999999999999999999', is beyond what can be counted"},
        {"a.obj", obj + "f 1 2 -9223372036854775808\n", "line 4", "vertex index is -92"},
        {"a.obj", obj + "f 1 2 3.0\n", "line 4", "must be an integer"},
        {"a.obj", obj + "f 1 2 x\n", "line 4", "'x'"},
        {"a.obj", obj + "f /1 /2 /3\n", "line 4", "vertex index is ''"},
        {"a.off", "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 3\n", "line 6", "names vertex 3"},
        {"a.off", "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 -1\n", "line 6", "names vertex -1"},
        {"a.off", "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 4294967296\n", "line 6", "4294967296"},
        {"a.ply", ascii_ply("0 0 0\n1 0 0\n0 1 0\n3 0 1 3\n"), "line 13", "names vertex 3"},
        {"a.ply", binary_face(3, {0, 1, -1}), "byte", "names vertex -1"},
        {"a.ply", binary_face(3, {0, 1, 1000000}), "byte", "names vertex 1000000"},
        // Coordinates.
        {"a.obj", "v 0 0 nan\n", "line 1", "'nan'"},
        {"a.obj", "v 0 -inf 0\n", "line 1", "'-inf'"},
        {"a.obj", "v 0 0 1e999\n", "line 1", "'1e999'"},
        {"a.obj", "v 0 0 abc\n", "line 1", "'abc'"},
        {"a.obj", "v 0 0\n", "line 1", "has 2 coordinates"},
        {"a.obj", "v 0,5 1,5 2,5\n", "line 1", "'0,5'"},
        {"a.obj", "v 0 0 0x1p3\n", "line 1", "'0x1p3'"},
        {"a.obj", "v 0 0 0 2\n", "line 1", "weight 2"},
        {"a.obj", "v 0 0 0 2\n", "line 1", "Export without weights (x y z alone)"},
        {"a.obj", "v 0 0 0 nan\n", "line 1", "take the fourth number away"},
        {"a.obj", obj + "f 1/x 2 3\n", "line 4", "corner is '1/x'"},
        {"a.obj", obj + "f 1/1/1/1 2 3\n", "line 4", "corner is '1/1/1/1'"},
        {"a.obj", "v 0 0 0 red\n", "line 1", "'red'"},
        {"a.obj", obj + "f 1 2 \\\nf 1 2 3\n", "line 5", "vertex index is 'f'"},
        {"a.obj", "v 0 0 \\\n", "line 1", "has 2 coordinates"},
        {"a.off", "OFF\n3 1 0\n0 0 0\n1 0 inf\n0 1 0\n3 0 1 2\n", "line 4", "'inf'"},
        {"a.off", "OFF\n3 1 0\n0.00 0 0\n1 0\n0 1 0\n3 0 1 2\n", "line 4",
         "coordinate z is missing"},
        {"a.off", "OFF\n3 1 0\n0 0 0\n1 0 0 0\n0 1 0\n3 0 1 2\n", "line 4", "unexpected '0'"},
        {"a.off", "OFF\n3 1 0\n0 0 0 red\n1 0 0\n0 1 0\n3 0 1 2\n", "line 3", "unexpected 'red'"},
        {"a.off", "OFF\n3 1 0\n0 0 0 1 0 0\n0 1\n3 0 1 2 9\n", "line 3",
         "run on over the lines, the last vertex does not end with its line"},
        {"a.off", "OFF\n3 1 0\n0 0 0 1.0000 0.0000 0.0000\n0 1\n", "line 3", "the file ends there"},
        {"a.off", "OFF\n3 1 0\n0 0 0 1 0 0 0 1 0 3 0 1 2 9\n", "line 3", "unexpected '1'"},
        {"a.off", "NOFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n", "line 3", "has 0 numbers"},
        {"a.off", "OFF\n3 2 0\n0.0 0 0\n1.0 0 0\n0 1 0\n3 0 1\n3 0 2 1\n", "line 6",
         "vertex index is missing"},
        {"a.off", "OFF\n3 1 0\n0.0 0 0\n1.0 0 0\n0 1 0\n3 0 1\n", "line 6",
         "vertex index is missing"},
        {"a.ply", ascii_ply("0 0 0\n1 nan 0\n0 1 0\n3 0 1 2\n"), "line 11", "'nan'"},
        {"a.ply", ascii_ply("0 0 0\n1 0\n0 1 0\n3 0 1 2\n"), "line 11", "is missing"},
        {"a.ply", ascii_ply("0 0 0\n1 0 0 0\n0 1 0\n3 0 1 2\n"), "line 11", "unexpected '0'"},
        {"a.ply", binary_nan + binary_face(3, {0, 1, 2}).substr(binary_nan.size()), "byte",
         "vertex 2 has a coordinate that is not finite"},
        // Encodings of the text.
        {"a.obj", std::string("\xFF\xFEv\0 \0", 6), "line 1", "byte order mark"},
        {"a.obj", "v 0 0 0\nv 1 0 0\rv 0 1 0\nf 1 2 3\n", "line 2", "CR"},
        {"a.off", "OFF\r3 1 0\r0 0 0\n1 0 0\r0 1 0\r3 0 1 2\r", "line 3", "CR"},
        {"a.ply", "ply\nformat ascii\r 1.0\n", "line 2", "CR"},
        {"a.obj", obj + std::string("v 0 0 \0\n", 8), "line 4", "NUL"},
        {"a.obj", std::string(1000, '\0'), "line 1", "NUL"},
        {"a.obj", obj + long_line + "f 1 2 3\n", "line 4", "longer than"},
        {"a.ply", std::string(std::size_t{3} << 20, 'x'), "line 1", "longer than"},
        // Counts.
        {"a.off", off_counts("4000000000 1 0"), "line 2", "do not fit in"},
        {"a.off", off_counts("100000000 1 0"), "line 2", "do not fit in"},
        {"a.off", off_counts("1 100000000 0"), "line 2", "do not fit in"},
        {"a.off", off_counts("99999999999999999999 1 0"), "line 2",
         "'99999999999999999999', is beyond what can be counted"},
        {"a.off", "OFF99999999999999999999 1 0\n", "line 1",
         "vertex count is '99999999999999999999', is beyond"},
        {"a.off", off_counts("9223372036854775807 9223372036854775807 0"), "line 2", "do not fit"},
        {"a.off", off_counts("-4 1 0"), "line 2", "vertex count is -4"},
        {"a.off", off_counts("3 -1 0"), "line 2", "face count is -1"},
        {"a.off", off_counts("3"), "line 2", "face count is missing"},
        {"a.off", off_counts("3\n0.5"), "line 2", "face count is missing"},
        {"a.off", off_counts("3 1 0 0"), "line 2", "unexpected '0'"},
        {"a.off", off_counts("0 0 0"), "line 3", "more lines"},
        {"a.off", "OFF\n0 0 0\n", "a.off", "0 vertices"},
        {"a.off", "OFF\n", "line 1", "counts are missing"},
        {"a.off", "OFF\n4 1 0\n0.000000 0 0\n1 0 0\n0 1 0\n3 0 1 2\n", "line 6", "unexpected '2'"},
        {"a.off", "OFF\n3 2 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n# not more\n", "line 7",
         "ends before face 1 of 2"},
        {"a.off", "OFF\n3 2 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2 3 0 2 1\n", "line 6",
         "two faces stand on this line"},
        {"a.off", "OFF\n3 2 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2 255 0 0\n", "line 6",
         "line 6: the file ends before face 1 of 2"},
        {"a.off", "COFF\n2 1 0\n0 0 0 9 9 9 1 0 0 9 9 9\n3 0 1 2\n", "line 3",
         "2 vertices would have as many"},
        {"a.off", "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n3 0 1 2\n", "line 7", "more lines"},
        {"a.ply", ply_counts("4000000000", "1"), "line 9", "do not fit in"},
        {"a.ply", ply_counts("100000000", "1"), "line 9", "do not fit in"},
        {"a.ply", ply_counts("3", "100000000"), "line 9", "do not fit in"},
        {"a.ply", ply_counts("-4", "1"), "line 3", "is -4"},
        {"a.ply", ply_counts("3.5", "1"), "line 3", "'3.5'"},
        {"a.ply", ply_counts("4", "1"), "line 13", "unexpected '2'"},
        {"a.ply", ply_counts("3", "2"), "line 13", "ends before face 1 of 2"},
        {"a.ply", ply_counts("2", "1"), "line 12", "0 corners"},
        {"a.ply", ply_counts("3", "0"), "line 13", "more lines"},
        {"a.ply", binary_face(3, {0, 1, 2}) + "x", "byte", "1 byte more"},
        {"a.ply", binary_face(3, {0, 1, 2}) + "\n\n", "byte", "2 bytes more"},
        {"a.ply", binary_face(3, {0, 1}), "byte", "within an element"},
        {"a.ply", binary_points, "byte", "do not fit in the remaining 0 bytes"},
        // Polygons.
        {"a.obj", obj + "f 1 2\n", "line 4", "2 corners"},
        {"a.obj", obj + "f\n", "line 4", "0 corners"},
        {"a.obj", obj + "v 1 1 0\nf 1 2 3 4\n", "line 5", "4 corners; polygons"},
        {"a.off", "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n1000000000 0 1 2\n", "line 6", "1000000000"},
        {"a.off", "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n0 0 1 2\n", "line 6", "0 corners"},
        {"a.off", "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n-3 0 1 2\n", "line 6", "-3"},
        {"a.off", "OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2 red\n", "line 6", "'red'"},
        {"a.ply", ascii_ply("0 0 0\n1 0 0\n0 1 0\n2 0 1\n"), "line 13", "2 corners"},
        {"a.ply", ascii_ply("0 0 0\n1 0 0\n0 1 0\n4 0 1 2 0\n"), "line 13", "4 corners"},
        {"a.ply", ascii_ply("0 0 0\n1 0 0\n0 1 0\n1000000000 0\n"), "line 13", "1000000000"},
        {"a.ply", ascii_ply("0 0 0\n1 0 0\n0 1 0\n-1 0\n"), "line 13", "-1 entries"},
        {"a.ply", binary_face(255, {0, 1, 2}), "byte", "within an element"},
        // Not this format.
        {"a.obj", "ply\nformat ascii 1.0\n", "line 1", "unknown statement 'ply'"},
        {"a.obj", "OFF\n3 1 0\n", "line 1", "unknown statement 'OFF'"},
        {"a.obj", obj + "curv 0 1 1 2\n", "line 4", "curved surface"},
        {"a.ply", obj, "line 1", "must be 'ply'"},
        {"a.off", obj, "line 1", "starts with 'v'"},
        {"a.off", "4OFF\n3 1 0\n", "line 1", "'4OFF'"},
        {"a.off", "CnOFF\n3 1 0\n", "line 1", "'CnOFF'"},
        {"a.off", "OFFSET 3 1 0\n", "line 1", "'SET'"},
        {"a.off", "OFF-3 1 0\n", "line 1", "'-3'"},
        {"a.off", "COFF\n4 1 0\n0 0 0 9 9 9\n1 0 0 9 9 9\n0 1 0 9 9 9\n3 0 1 2\n", "line 6",
         "1 number after the coordinates, must have 3 to 4"},
        {"a.off", "NOFF\n1 0 0\n0 0 0 a b c\n", "line 3", "'a'"},
        {"a.off", "OFF BINARY\n", "line 1", "BINARY"},
        // Headers of PLY.
        {"a.ply", "ply\n", "line 1", "format"},
        {"a.ply", "ply\nelement vertex 3\n", "line 2", "format"},
        {"a.ply", "ply\ncomment only\n", "line 2", "format"},
        {"a.ply", "ply\nformat ascii 1.0\nformat ascii 1.0\n", "line 3", "'format'"},
        {"a.ply",
         "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\nproperty "
         "float z\nelement tristrips 1\nproperty list int int vertex_indices\nend_header\n",
         "line 9", "triangle strips"},
        {"a.ply",
         "ply\nformat ascii 1.0\nelement vertex 1\nproperty float x\nproperty float y\nproperty "
         "float z\nend_header\n0 0 0\n",
         "line 7", "point cloud"},
        {"a.ply", "ply\nformat ascii 2.0\n", "line 2", "'2.0'"},
        {"a.ply", "ply\nformat utf8 1.0\n", "line 2", "'utf8'"},
        {"a.ply", "ply\nformat ascii 1.0\nelement vertex 3\n", "line 3", "no end_header"},
        {"a.ply", "ply\nformat ascii 1.0\nend_header\n", "line 3", "no element 'vertex'"},
        {"a.ply", "ply\nformat ascii 1.0\nproperty float x\n", "line 3",
         "before the first element"},
        {"a.ply", "ply\nformat ascii 1.0\nelement vertex 3\nproperty float128 x\n", "line 4",
         "unknown type 'float128'"},
        {"a.ply", "ply\nformat ascii 1.0\nelement vertex 3\nproperty float\n", "line 4",
         "name of the property is missing"},
        {"a.ply", "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float x\n",
         "line 5", "declared twice"},
        {"a.ply", "ply\nformat ascii 1.0\nelement vertex 3\nelement vertex 3\n", "line 4",
         "declared twice"},
        {"a.ply",
         "ply\nformat ascii 1.0\nelement face 1\nproperty list uchar int vertex_indices\nelement "
         "vertex "
         "3\nproperty float x\nproperty float y\nproperty float z\nend_header\n3 0 1 3\n0 0 0\n1 0 "
         "0\n0 1 0\n",
         "line 10", "names vertex 3"},
        {"a.ply", "ply\nformat ascii 1.0\nelement vertex 3\nproperty list float int x\n", "line 4",
         "integer type"},
        {"a.ply", "ply\nformat ascii 1.0\nelement vertex 3\nproperty list uchar int x\n", "line 4",
         "must not be a list"},
        {"a.ply", "ply\nformat ascii 1.0\nelement vertex\n", "line 3", "count of the element"},
        {"a.ply", "ply\nformat ascii 1.0\nelement\n", "line 3", "name of the element"},
        {"a.ply", "ply\nformat ascii 1.0\nvertices 3\n", "line 3", "'vertices'"},
        {"a.ply",
         "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float "
         "y\nend_header\n",
         "line 6", "x, y and z"},
        {"a.ply",
         "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n"
         "property float z\nelement face 1\nproperty list uchar float vertex_indices\n",
         "line 8", "list of integers"},
        {"a.ply",
         "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n"
         "property float z\nelement face 1\nproperty list uchar int corners\nend_header\n",
         "line 9", "vertex_indices"},
        {"a.ply",
         "ply\nformat binary_little_endian 1.0\nelement dust 4000000000\nelement vertex 3\n"
         "property float x\nproperty float y\nproperty float z\nelement face 1\n"
         "property list uchar int vertex_indices\nend_header\n",
         "line 10", "'dust' has no properties"},
    };
    return files;
}

TEST(MeshFile, NamesFilePlaceAndRuleOfWhatItRefuses)
{
    for (const BadFile& file : bad_files()) {
        SCOPED_TRACE(file.name + ": " + file.content.substr(0, 300));
        const std::string message =
            test::message_of<InvalidInput>([&] { (void)read(file.name, file.content); });
        EXPECT_NE(message.find(file.name + ": "), std::string::npos) << message;
        EXPECT_NE(message.find(file.place), std::string::npos) << message;
        EXPECT_NE(message.find(file.rule), std::string::npos) << message;
        EXPECT_LT(message.size(), 400u) << message;
    }
}

TEST(MeshFile, NamesTheByteOfABinaryError)
{
    std::string bytes = binary_header;
    const std::size_t header = bytes.size();
    for (const double value : {0, 0, 0, 1, 0, 0, 0, 1, 0})
        append_scalar<float>(bytes, value, false);
    bytes += '\3';
    for (const int v : {0, 1, 3})
        append_scalar<std::int32_t>(bytes, v, false);
    const std::string message = test::message_of<InvalidInput>([&] { (void)read("m.ply", bytes); });
    EXPECT_NE(message.find(join("byte ", header + 36 + 13)), std::string::npos) << message;
}

TEST(MeshFile, LimitsPolygonsItIsAskedToSplit)
{
    std::string text = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf";
    for (int i = 0; i < 1025; ++i)
        text += " 1";
    const std::string message =
        test::message_of<InvalidInput>([&] { (void)read("m.obj", text + "\n", true); });
    EXPECT_NE(message.find("line 4"), std::string::npos) << message;
    EXPECT_NE(message.find("1024"), std::string::npos) << message;
}

TEST(MeshFile, RefusesWhatIsNotARegularFileWithoutReadingIt)
{
    const test::TemporaryDirectory directory;
    std::filesystem::create_directory(directory / "folder.obj");
    ASSERT_EQ(::mkfifo((directory / "fifo.obj").c_str(), 0600), 0);
    std::filesystem::create_symlink("/dev/zero", directory / "zero.obj");
    std::filesystem::create_symlink("loop.obj", directory / "loop.obj");
    const auto message = [&](const char* name) {
        return test::message_of<FileError>([&] { (void)read_mesh(directory / name); });
    };
    EXPECT_NE(message("folder.obj").find("is a directory"), std::string::npos);
    EXPECT_NE(message("fifo.obj").find("not a regular file"), std::string::npos);
    EXPECT_NE(message("zero.obj").find("not a regular file"), std::string::npos);
    EXPECT_NE(message("loop.obj").find("symbolic links"), std::string::npos);
    EXPECT_NE(message("missing.obj").find("missing.obj: No such file"), std::string::npos);
}

TEST(MeshFile, RefusesFilesBeyondItsLimitBeforeReadingThem)
{
    const test::TemporaryDirectory directory;
    test::write_bytes(directory / "large.obj", "");
    std::filesystem::resize_file(directory / "large.obj", std::uintmax_t{1} << 40); // sparse
    const std::string message =
        test::message_of<LimitExceeded>([&] { (void)read_mesh(directory / "large.obj"); });
    EXPECT_NE(message.find("large.obj"), std::string::npos) << message;
    EXPECT_NE(message.find("2147483648"), std::string::npos) << message;
}

/// The files of one small mesh in every format and encoding, whole.
std::vector<std::pair<std::string, std::string>> valid_files()
{
    const test::TemporaryDirectory directory;
    const test::TestMesh mesh = test::icosphere(0);
    std::vector<std::pair<std::string, std::string>> files;
    for (const MeshFormat format : {MeshFormat::Obj, MeshFormat::Ply, MeshFormat::Off}) {
        const std::string name = "m" + file_ending(format);
        write_mesh(directory / name, mesh.points, mesh.topology.faces(), format);
        files.emplace_back(name, test::read_bytes(directory / name));
    }
    std::string text =
        "ply\nformat ascii 1.0\nelement vertex 12\nproperty double x\nproperty double "
        "y\nproperty double z\nelement face 20\nproperty list uchar int "
        "vertex_indices\nend_header\n";
    const std::string off = files[2].second;
    text += off.substr(off.find("20 0\n") + 5);
    files.emplace_back("m.ply", text);
    return files;
}

TEST(MeshFile, AHeaderMayDeclareAHundredThousandPropertiesAndElements)
{
    std::string elements; // in time that is quadratic: minutes
    std::string properties;
    for (int i = 0; i < 100'000; ++i) {
        elements += join("element e", i, " 0\nproperty float x\n");
        properties += join("property float p", i, "\n");
    }
    const auto file_of = [&](const std::string& last) {
        return "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\n"
               "property float z\nelement face 1\nproperty list uchar int vertex_indices\n" +
               elements + "element other 0\n" + properties + last +
               "end_header\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n";
    };
    EXPECT_EQ(read("a.ply", file_of("")).points.rows(), 3);
    EXPECT_NE(test::message_of<InvalidInput>([&] {
                  (void)read("a.ply", file_of("property float p0\n"));
              }).find("'p0' is declared twice"),
              std::string::npos);
}

TEST(MeshFile, RefusesTruncatedFiles)
{
    for (const auto& [name, content] : valid_files()) {
        SCOPED_TRACE(name + content.substr(0, 20));
        const NamedMesh whole = read(name, content);
        const bool is_text = content.find("binary") == std::string::npos;
        // Text does not tell how long its last number is, and OBJ not how many lines it has.
        const std::size_t last_number = is_text ? content.find_last_of(' ') + 2 : content.size();
        for (std::size_t size = 0; size < content.size(); ++size) {
            if (name == "m.obj" || size >= last_number) {
                try {
                    const NamedMesh part = read(name, content.substr(0, size));
                    EXPECT_LE(part.faces.rows(), whole.faces.rows());
                    EXPECT_EQ(part.points, whole.points);
                    const Eigen::Index complete = part.faces.rows() - 1;
                    EXPECT_EQ(part.faces.topRows(complete), whole.faces.topRows(complete));
                } catch (const InvalidInput&) {
                }
            } else {
                EXPECT_THROW((void)read(name, content.substr(0, size)), InvalidInput) << size;
            }
        }
    }
}

TEST(MeshFile, ReadsOrRefusesDamagedFilesButNeverCrashes)
{
    Random random(3);
    for (const auto& [name, content] : valid_files()) {
        int refused = 0;
        for (int round = 0; round < 500; ++round) {
            std::string bytes = content;
            for (std::uint64_t flips = 1 + random.index(3); flips > 0; --flips)
                bytes[random.index(bytes.size())] ^= static_cast<char>(1 << random.index(8));
            try {
                const NamedMesh mesh = read(name, bytes, random.index(2) == 0);
                EXPECT_TRUE(mesh.points.allFinite());
                EXPECT_GE(mesh.faces.minCoeff(), 0);
                EXPECT_LT(mesh.faces.maxCoeff(), mesh.points.rows());
            } catch (const InvalidInput&) {
                ++refused;
            }
        }
        EXPECT_GT(refused, 20) << name;
    }
}

/// Sum of the areas of the faces, and the area that they cover seen from above.
std::pair<double, double> areas_of(const NamedMesh& mesh)
{
    std::pair<double, double> areas;
    for (const auto& face : mesh.faces.rowwise()) {
        const Eigen::RowVector3d at = mesh.points.row(face[0]);
        const Eigen::RowVector3d normal =
            (mesh.points.row(face[1]) - at)
                .cross(Eigen::RowVector3d(mesh.points.row(face[2]) - at));
        areas.first += 0.5 * normal.norm();
        areas.second += 0.5 * normal[2];
    }
    return areas;
}

/// An L of area 3 from each of its corners in turn, beside a square; OBJ.
std::string concave_obj(int first, double notch = 1.0)
{
    std::string text = join("v 0 0 0\nv 2 0 0\nv 2 1 0\nv ", notch, " ", notch,
                            " 0\nv 1 2 0\nv 0 2 0\nv 0 3 0\nv 1 3 0\nf 6 5 8 7\nf");
    for (int i = 0; i < 6; ++i)
        text += join(" ", (first + i) % 6 + 1);
    return text + "\n";
}

TEST(MeshFile, CutsConcavePolygonsWithoutFolds)
{
    for (int first = 0; first < 6; ++first) {
        const NamedMesh mesh = read("l.obj", concave_obj(first), true);
        EXPECT_EQ(mesh.faces.rows(), 6);
        EXPECT_NEAR(areas_of(mesh).first, 4.0, 1e-12) << first;
        EXPECT_NEAR(areas_of(mesh).second, 4.0, 1e-12) << first;
    }
    // Fans that do stay as they were.
    EXPECT_EQ(read("l.obj", concave_obj(3), true).faces.row(2), Eigen::RowVector3i(3, 4, 5));
    const std::string message = test::message_of<InvalidInput>([&] {
        (void)read("x.obj", "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\nf 1 3 2 4\n", true);
    });
    EXPECT_NE(message.find("face 1 (vertices 0, 2, 1, 3) crosses itself"), std::string::npos)
        << message;
}

TEST(MeshFile, CutsThePolygonsOfSeveralFilesAsThoseOfTheFirst)
{
    const test::TemporaryDirectory directory;
    const auto read_with = [&](const std::string& text, PolygonCuts* cuts) {
        test::write_bytes(directory / "m.obj", text);
        return read_mesh(directory / "m.obj", {.triangulate = true, .cuts = cuts});
    };
    PolygonCuts cuts;
    const NamedMesh concave = read_with(concave_obj(1), &cuts);
    const std::string convex_text = concave_obj(1, 1.7);
    EXPECT_NE(read_with(convex_text, nullptr).faces, concave.faces);
    EXPECT_EQ(read_with(convex_text, &cuts).faces, concave.faces);
    EXPECT_TRUE(cuts.folded.empty());
    EXPECT_EQ(cuts.cut_meshes, 2U);
    // The other way round, the concave one folds over, which is said.
    PolygonCuts others;
    const NamedMesh convex = read_with(convex_text, &others);
    EXPECT_EQ(read_with(concave_obj(1), &others).faces, convex.faces);
    ASSERT_EQ(others.folded.size(), 1U);
    EXPECT_EQ(others.folded[0].path, (directory / "m.obj").string());
    const std::string& said = others.folded[0].message;
    EXPECT_NE(said.find("1 polygon cut as in "), std::string::npos) << said;
    EXPECT_NE(said.find("folds over there, first face 1 (vertices 1, 2, 3, 4, 5, 0)"),
              std::string::npos)
        << said;
    // Whichever corner it begins with.
    EXPECT_EQ(read_with(concave_obj(2), &others).faces, convex.faces);
    EXPECT_EQ(others.folded.size(), 2U);
    // Other polygons are cut as they need it, and those that follow as they are.
    const std::string other_corners = "f 1 2 3 4\nf 6 5 8 7\nf 4 5 6 1\n";
    const auto other_obj = [&](double notch) {
        const std::string text = concave_obj(1, notch);
        return text.substr(0, text.find("f ")) + other_corners;
    };
    const NamedMesh other = read_with(other_obj(1.0), &others);
    EXPECT_EQ(others.folded.size(), 2U);
    EXPECT_EQ(read_with(other_obj(1.2), &others).faces, other.faces);
}

/// A strip of three quads, or its triangles.
std::string strip_obj(const std::string& faces, double bend = 0.0)
{
    std::string text;
    for (int i = 0; i < 8; ++i)
        text += join("v ", i / 2, " ", i % 2, " ", i == 5 ? bend : 0.0, "\n");
    return text + faces;
}

TEST(MeshFile, CutsPolygonsByTheDiagonalsOfAKnownTriangulation)
{
    const test::TemporaryDirectory directory;
    const auto read_with = [&](const std::string& text, PolygonCuts* cuts) {
        test::write_bytes(directory / "m.obj", text);
        return read_mesh(directory / "m.obj", {.triangulate = true, .cuts = cuts});
    };
    const std::string quads = "f 1 3 4 2\nf 3 5 6 4\nf 5 7 8 6\n";
    // In the order of the quads, in another one that begins elsewhere, and with the same edges of only two of them.
    const std::string known = "f 1 3 2\nf 3 4 2\nf 3 5 6\nf 3 6 4\nf 5 7 8\nf 5 8 6\n";
    const std::string moved = "f 8 5 7\nf 4 2 3\nf 3 5 6\nf 3 6 4\nf 3 2 1\nf 5 8 6\n";
    const std::string partly = "f 1 3 2\nf 3 4 2\nf 3 5 4\nf 5 6 4\nf 5 7 1\nf 5 8 6\n";
    const auto faces_of = [&](const std::string& text) {
        return read_with(strip_obj(text), nullptr).faces;
    };
    const auto as_known = [&](const std::string& triangles, const std::string& polygons) {
        PolygonCuts cuts;
        (void)read_with(strip_obj(triangles), &cuts);
        const Faces faces = read_with(strip_obj(polygons, 0.3), &cuts).faces;
        EXPECT_EQ(cuts.cut_meshes, 1U);
        EXPECT_TRUE(cuts.folded.empty());
        return faces;
    };
    EXPECT_NE(faces_of(quads), faces_of(known));
    EXPECT_EQ(as_known(known, quads), faces_of(known));
    EXPECT_EQ(as_known(moved, quads), faces_of(moved));
    EXPECT_EQ(as_known(known, "f 5 6 4 3\nf 1 3 4 2\nf 7 8 6 5\n"), faces_of(known));
    EXPECT_EQ(as_known(known, "f 1 3 5 6 4 2\nf 5 7 8 6\n"), faces_of(known));
    EXPECT_EQ(as_known(known, "f 1 3 5 7 8 6 4 2\n"), faces_of(known));
    EXPECT_EQ(as_known(known, "f 1 3 2\nf 3 4 2\nf 3 5 6 4\nf 5 7 8 6\n"), faces_of(known));
    // What has no such cut is cut as alone.
    EXPECT_EQ(as_known(partly, quads).topRows(4), faces_of(partly).topRows(4));
    EXPECT_EQ(as_known(partly, quads).bottomRows(2), faces_of(quads).bottomRows(2));
    // The other way round: the known one turned over.
    EXPECT_EQ(as_known(known, "f 2 4 3 1\nf 4 6 5 3\nf 6 8 7 5\n"),
              faces_of("f 1 2 3\nf 3 2 4\nf 3 6 5\nf 3 4 6\nf 5 8 7\nf 5 6 8\n"));
    // Of other counts it says nothing.
    PolygonCuts cuts;
    (void)read_with(strip_obj("f 1 3 2\nf 3 4 2\n"), &cuts);
    EXPECT_EQ(read_with(strip_obj(quads), &cuts).faces, faces_of(quads));
    // Nor does what is no surface.
    for (const char* odd : {"f 1 1 1\nf 1 3 2\nf 1 3 2\nf 3 4 2\nf 3 4 2\nf 1 2 2\n",
                            "f 1 2 3\nf 1 3 4\nf 1 4 5\nf 1 5 6\nf 1 6 7\nf 1 7 8\n"})
        EXPECT_EQ(as_known(odd, quads).bottomRows(4), faces_of(quads).bottomRows(4));
}

TEST(MeshFile, CutsAllPolygonsAnewAsALaterMeshOfTriangles)
{
    const test::TemporaryDirectory directory;
    const auto read_with = [&](const std::string& text, PolygonCuts& cuts) {
        test::write_bytes(directory / "m.obj", text);
        return read_mesh(directory / "m.obj", {.triangulate = true, .cuts = &cuts}).faces;
    };
    const std::string quads = strip_obj("f 1 3 4 2\nf 3 5 6 4\nf 5 7 8 6\n");
    const std::string triangles =
        strip_obj("f 1 3 2\nf 3 4 2\nf 3 5 6\nf 3 6 4\nf 5 7 8\nf 5 8 6\n");
    PolygonCuts cuts;
    (void)read_with(quads, cuts);
    EXPECT_FALSE(better_cuts(cuts));
    const Faces wanted = read_with(triangles, cuts);
    std::optional<PolygonCuts> better = better_cuts(cuts);
    ASSERT_TRUE(better);
    EXPECT_EQ(read_with(quads, *better), wanted);
    EXPECT_EQ(read_with(triangles, *better), wanted);
    EXPECT_FALSE(better_cuts(*better));
    // Not as one whose vertices are others.
    PolygonCuts none;
    (void)read_with(quads, none);
    (void)read_with(strip_obj("f 1 3 5\nf 3 4 2\nf 3 2 6\nf 3 6 4\nf 5 7 8\nf 5 8 6\n"), none);
    EXPECT_FALSE(better_cuts(none));
}

TEST(MeshFile, RefusesPolygonsThatCrossThemselvesInFurtherFilesToo)
{
    const test::TemporaryDirectory directory;
    const auto read_with = [&](const std::string& text, PolygonCuts& cuts) {
        test::write_bytes(directory / "m.obj", text);
        return read_mesh(directory / "m.obj", {.triangulate = true, .cuts = &cuts});
    };
    const std::string square = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n";
    const std::string crossed = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\nf 1 2 3 4\n";
    PolygonCuts cuts;
    (void)read_with(square, cuts);
    const std::string message =
        test::message_of<InvalidInput>([&] { (void)read_with(crossed, cuts); });
    EXPECT_NE(message.find("m.obj: face 0 (vertices 0, 1, 2, 3) crosses itself"), std::string::npos)
        << message;
    EXPECT_TRUE(cuts.folded.empty());
}

TEST(MeshFile, WritesAsATemplateOfPolygonsThatTheMeshesAreCutOf)
{
    const test::TemporaryDirectory directory;
    test::write_bytes(directory / "t.obj", strip_obj("f 1 3 4 2\nf 3 5 6 4\nf 5 7 8 6\n"));
    test::write_bytes(directory / "m.obj",
                      strip_obj("f 1 3 2\nf 3 4 2\nf 3 5 6\nf 3 6 4\nf 5 7 8\nf 5 8 6\n", 0.3));
    const NamedMesh mesh = read_mesh(directory / "m.obj");
    MeshWriteOptions options;
    options.obj_template = std::make_shared<const ObjTemplate>(
        read_obj_template(directory / "t.obj", directory.path()));
    write_mesh(directory / "o.obj", mesh.points, mesh.faces, MeshFormat::Obj, options);
    const std::string text = test::read_bytes(directory / "o.obj");
    EXPECT_NE(text.find("f 3 5 6 4\n"), std::string::npos) << text;
    EXPECT_EQ(read_mesh(directory / "o.obj", {.triangulate = true}).points, mesh.points);
    Faces other = mesh.faces;
    other(0, 0) = 7;
    EXPECT_THROW(write_mesh(directory / "o.obj", mesh.points, other, MeshFormat::Obj, options),
                 InvalidInput);
}

} // namespace
} // namespace shape
