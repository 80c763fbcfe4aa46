// SPDX-License-Identifier: MIT

#include "libshape/io/collection_file.h"

#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <cstddef>
#include <filesystem>
#include <string_view>

#include "libshape/base/error.h"
#include "libshape/base/format.h"
#include "libshape/base/random.h"
#include "libshape/base/to_size.h"
#include "libshape/io/collection_stream.h"
#include "libshape/io/model_file.h"
#include "tests/support/files.h"
#include "tests/support/h5py.h"
#include "tests/support/meshes.h"

namespace shape {
using namespace internal;
namespace {

Collection bumpy_collection()
{
    const test::TestMesh first = test::bumpy_sphere(1, 0.3, 1);
    Collection collection{first.topology, {}, {}, {}};
    for (unsigned seed = 1; seed <= 4; ++seed) {
        collection.names.push_back(join("bumpy ", seed, seed == 4 ? " Größe" : ""));
        collection.points.push_back(test::moved(test::bumpy_sphere(1, 0.3, seed).points, seed));
    }
    collection.labels = {{"zeta", {"a", "", "b", "ä"}}, {"alpha", {"1", "2", "3", "4"}}};
    return collection;
}

void expect_equal(const Collection& a, const Collection& b)
{
    EXPECT_TRUE(a.topology == b.topology);
    EXPECT_EQ(a.names, b.names);
    EXPECT_EQ(a.points, b.points);
    ASSERT_EQ(a.labels.size(), b.labels.size());
    for (std::size_t c = 0; c < a.labels.size(); ++c) {
        EXPECT_EQ(a.labels[c].name, b.labels[c].name);
        EXPECT_EQ(a.labels[c].values, b.labels[c].values);
    }
}

TEST(CollectionFile, GivesEveryBitBack)
{
    const test::TemporaryDirectory directory;
    for (const test::TestMesh& mesh : test::sample_meshes()) {
        SCOPED_TRACE(mesh.name);
        const Collection collection{mesh.topology, {mesh.name}, {mesh.points}, {}};
        write_collection(directory / "c.h5", collection);
        expect_equal(read_collection(directory / "c.h5"), collection);
    }
    const Collection collection = bumpy_collection();
    write_collection(directory / "c.h5", collection);
    expect_equal(read_collection(directory / "c.h5"), collection);
    EXPECT_EQ(file_kind(directory / "c.h5"), FileKind::Collection);
    EXPECT_EQ(directory.names(), std::vector<std::string>{"c.h5"});
}

TEST(CollectionFile, GivesMeshesBackThatFillSeveralChunks)
{
    // 68 meshes of 642 vertices are one MiB.
    const test::TemporaryDirectory directory;
    const test::TestMesh mesh = test::bumpy_sphere(3, 0.3, 1);
    Collection collection{mesh.topology, {}, {}, {}};
    for (int i = 0; i < 150; ++i) {
        collection.names.push_back(join(i));
        collection.points.emplace_back((1.0 + 0.01 * i) * mesh.points);
    }
    write_collection(directory / "c.h5", collection);
    expect_equal(read_collection(directory / "c.h5"), collection);
}

/// The meshes [begin, end) of the bumpy collection.
Collection some_of_them(std::size_t begin, std::size_t end)
{
    Collection some = bumpy_collection();
    const auto cut = [&](auto& values) {
        values.resize(end);
        values.erase(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(begin));
    };
    cut(some.names);
    cut(some.points);
    for (LabelColumn& column : some.labels)
        cut(column.values);
    return some;
}

TEST(CollectionFile, AppendedMeshesGiveTheBytesOfAllOfThemStoredAsTheFirstOnes)
{
    const test::TemporaryDirectory directory;
    const Collection added = some_of_them(3, 4);
    for (const CollectionFileOptions stored :
         {CollectionFileOptions{}, {.derived = true}, {.compress = true}, {true, true}})
        for (const CollectionFileOptions wanted :
             {CollectionFileOptions{}, {.derived = true}, {.compress = true}}) {
            write_collection(directory / "all.h5", bumpy_collection(),
                             {.derived = stored.derived || wanted.derived,
                              .compress = stored.compress || wanted.compress});
            write_collection(directory / "c.h5", some_of_them(0, 3), stored);
            EXPECT_EQ(append_to_collection(directory / "c.h5", stream_of(added), wanted), 4);
            EXPECT_EQ(test::read_bytes(directory / "c.h5"), test::read_bytes(directory / "all.h5"));
        }
    EXPECT_EQ(directory.names(), (std::vector<std::string>{"all.h5", "c.h5"}));
}

TEST(CollectionFile, OfTwoThatAppendAtOnceTheLaterOneFailsAndLosesNothing)
{
    const test::TemporaryDirectory directory;
    const std::filesystem::path file = directory / "c.h5";
    const Collection late = some_of_them(3, 4);
    const Collection early = some_of_them(2, 3);
    const auto message = [&](const auto& meanwhile) {
        write_collection(file, some_of_them(0, 2));
        return test::message_of<FileError>([&] {
            append_to_collection(file, stream_of(late), {},
                                 [&](std::string_view, std::size_t done, std::size_t total) {
                                     if (done == total)
                                         meanwhile();
                                 });
        });
    };
    const std::string changed =
        file.string() + " changed while meshes were appended to it; append again";
    EXPECT_EQ(message([&] { append_to_collection(file, stream_of(early)); }), changed);
    expect_equal(read_collection(file), some_of_them(0, 3));
    // Another file of the same bytes, the same file at another time, and none.
    EXPECT_EQ(message([&] { write_collection(file, some_of_them(0, 2)); }), changed);
    EXPECT_EQ(message([&] {
                  std::filesystem::last_write_time(
                      file, std::filesystem::last_write_time(file) - std::chrono::seconds(5));
              }),
              changed);
    expect_equal(read_collection(file), some_of_them(0, 2));
    EXPECT_EQ(message([&] { std::filesystem::remove(file); }), changed);
    EXPECT_EQ(directory.names(), std::vector<std::string>{});
}

TEST(CollectionFile, NothingIsAppendedToALinkOrToWhatIsNotThere)
{
    const test::TemporaryDirectory directory;
    const Collection added = some_of_them(3, 4);
    const auto message = [&](const std::string& name) {
        return test::message_of<FileError>(
            [&] { append_to_collection(directory / name, stream_of(added)); });
    };
    EXPECT_NE(message("none.h5").find("none.h5: No such file"), std::string::npos);
    write_collection(directory / "c.h5", some_of_them(0, 2));
    std::filesystem::create_symlink("c.h5", directory / "link.h5");
    EXPECT_NE(message("link.h5").find("name the file it points to"), std::string::npos);
    expect_equal(read_collection(directory / "c.h5"), some_of_them(0, 2));
}

TEST(CollectionFile, HasTheSameBytesForTheSameCollection)
{
    const test::TemporaryDirectory directory;
    write_collection(directory / "a.h5", bumpy_collection());
    write_collection(directory / "b.h5", bumpy_collection());
    EXPECT_EQ(test::read_bytes(directory / "a.h5"), test::read_bytes(directory / "b.h5"));
}

TEST(CollectionFile, RefusesToWriteWhatItWouldNotReadAndKeepsTheOldFile)
{
    const test::TemporaryDirectory directory;
    test::write_bytes(directory / "c.h5", "old");
    const auto message = [&](const auto& spoil) {
        Collection collection = bumpy_collection();
        spoil(collection);
        return test::message_of<InvalidInput>(
            [&] { write_collection(directory / "c.h5", collection); });
    };
    using C = Collection;
    EXPECT_NE(message([](C& c) { c.names[1] = c.names[0]; }).find("'bumpy 1' occurs twice"),
              std::string::npos);
    EXPECT_NE(message([](C& c) { c.names[1] = ""; }).find("a mesh has no name"), std::string::npos);
    EXPECT_NE(message([](C& c) { c.names[1] = "caf\xE9"; }).find("UTF-8"), std::string::npos);
    EXPECT_NE(message([](C& c) { c.names[1] = std::string("a\0b", 3); }).find("NUL"),
              std::string::npos);
    EXPECT_NE(message([](C& c) { c.names[1] = std::string(5000, 'x'); }).find("4096"),
              std::string::npos);
    EXPECT_NE(message([](C& c) { c.names.pop_back(); }).find("/names"), std::string::npos);
    for (const std::string& name :
         {std::string(), std::string("a\0b", 3), std::string("zeta"), std::string(4097, 'x'),
          std::string(1366, '/')}) // of three bytes each
        EXPECT_NE(message([&](C& c) { c.labels[1].name = name; }).find("label column"),
                  std::string::npos);
    EXPECT_NE(message([](C& c) { c.labels[0].values.pop_back(); }).find("/labels/zeta"),
              std::string::npos);
    EXPECT_NE(message([](C& c) { c.points[2](5, 1) = std::nan(""); }).find("mesh 2"),
              std::string::npos);
    EXPECT_NE(message([](C& c) { c.points[3].setZero(); }).find("mesh 3"), std::string::npos);
    EXPECT_NE(message([](C& c) { c.points[1].conservativeResize(5, 3); }).find("5 rows"),
              std::string::npos);
    EXPECT_NE(message([](C& c) {
                  c = C{c.topology, {}, {}, {}};
              }).find("at least 1"),
              std::string::npos);
    EXPECT_EQ(test::read_bytes(directory / "c.h5"), "old");
    EXPECT_EQ(directory.names(), std::vector<std::string>{"c.h5"});
}

TEST(CollectionFile, KeepsLabelsOfAnyName)
{
    const test::TemporaryDirectory directory;
    Collection collection = bumpy_collection();
    collection.labels.clear();
    for (const std::string& name :
         {std::string("50%2F"), std::string(".."), std::string(4096, 'x')})
        collection.labels.push_back({name, {"a", "", "b", "c"}});
    write_collection(directory / "plain.h5", collection); // as files of before have them
    expect_equal(read_collection(directory / "plain.h5"), collection);
    for (const char* name : {"M/F", "kg/m2", ".", "/", "%", "%2F"})
        collection.labels.push_back({name, {"1", "2", "", "4"}});
    collection.labels[2].name = "x";
    write_collection(directory / "any.h5", collection);
    expect_equal(read_collection(directory / "any.h5"), collection);
    EXPECT_EQ(open_collection(directory / "any.h5").labels[3].name, "M/F");
    if (test::python_with_h5py().empty())
        GTEST_SKIP() << "no Python with h5py";
    EXPECT_EQ(test::run_h5py(directory / "plain.h5", "r",
                             "print('label_names' in f.attrs, [n[:5] for n in f['labels']])\n"),
              "False ['50%2F', '..', 'xxxxx']\n");
    EXPECT_EQ(test::run_h5py(directory / "any.h5", "r",
                             "from urllib.parse import unquote\n"
                             "print(f.attrs['label_names'].decode(), list(f['labels'])[3])\n"
                             "print(*map(unquote, f['labels']))\n"),
              "percent-encoded M%2FF\n50%2F .. x M/F kg/m2 . / % %2F\n");
    const std::string rename = "f['labels'].move('M%2FF', ";
    test::expect_refused(
        directory / "any.h5",
        {{"f.attrs['label_names'] = np.bytes_('as they are')", "attribute label_names",
          "must be 'percent-encoded'"},
         {rename + "'M%2')", "/labels/M%2", "not percent-encoded"},
         {rename + "'M%GG')", "/labels/M%GG", "not percent-encoded"},
         {rename + "'M%00')", "/labels/M%00", "not percent-encoded"},
         {rename + "'M%C3')", "/labels/M%C3", "not percent-encoded"},
         {rename + "'kg%2fm2')", "/labels/kg%2fm2", "a second label is called 'kg/m2'"},
         {rename + "'%20x')", "/labels/%20x", "one name but for blanks"}},
        [](const std::filesystem::path& file) { (void)read_collection(file); });
}

TEST(CollectionFile, WritesNoLabelsThatTablesWouldTakeForOne)
{
    const test::TemporaryDirectory directory;
    Collection collection = bumpy_collection();
    for (const char* name : {"g", " g"})
        collection.labels.push_back({name, {"1", "2", "", "4"}});
    EXPECT_NE(test::message_of<InvalidInput>([&] {
                  write_collection(directory / "c.h5", collection);
              }).find("label column ' g' occurs twice, perhaps but for blanks"),
              std::string::npos);
}

TEST(CollectionFile, TakesNoMoreLabelsThanItCouldRead)
{
    const test::TemporaryDirectory directory;
    Collection collection = bumpy_collection();
    const std::vector<std::string> values(collection.size(), "x");
    collection.labels.clear();
    while (collection.labels.size() < 4097)
        collection.labels.push_back({join("c", collection.labels.size()), values});
    EXPECT_NE(test::message_of<LimitExceeded>([&] {
                  write_collection(directory / "c.h5", collection);
              }).find("4097 label columns"),
              std::string::npos);
}

TEST(CollectionFile, SaysWhyItCannotBeWritten)
{
    const std::string message = test::message_of<FileError>(
        [] { write_collection("/nowhere/at/all/c.h5", bumpy_collection()); });
    EXPECT_NE(message.find("/nowhere/at/all"), std::string::npos) << message;
    EXPECT_NE(message.find("No such file"), std::string::npos) << message;
}

TEST(CollectionFile, RefusesWhatIsNotHdf5)
{
    const test::TemporaryDirectory directory;
    for (const char* content : {"", "x", "ply\nformat ascii 1.0\n", "\x89HDF\r\n\x1a"}) {
        test::write_bytes(directory / "c.h5", content);
        const std::string message =
            test::message_of<InvalidInput>([&] { (void)read_collection(directory / "c.h5"); });
        EXPECT_NE(message.find("c.h5: is not an HDF5 file"), std::string::npos) << message;
    }
    std::filesystem::create_directory(directory / "d.h5");
    EXPECT_THROW((void)read_collection(directory / "d.h5"), FileError);
    EXPECT_THROW((void)read_collection(directory / "missing.h5"), FileError);
    EXPECT_THROW((void)file_kind("/dev/zero"), FileError);
}

TEST(CollectionFile, SaysThatAUserBlockIsNotRead)
{
    const test::TemporaryDirectory directory;
    write_collection(directory / "c.h5", bumpy_collection());
    test::write_bytes(directory / "c.h5",
                      std::string(1024, ' ') + test::read_bytes(directory / "c.h5"));
    const std::string message =
        test::message_of<InvalidInput>([&] { (void)read_collection(directory / "c.h5"); });
    EXPECT_NE(message.find("c.h5: has a user block of 1024 bytes"), std::string::npos) << message;
}

TEST(CollectionFile, RefusesTruncatedFiles)
{
    const test::TemporaryDirectory directory;
    write_collection(directory / "c.h5", bumpy_collection());
    const std::string bytes = test::read_bytes(directory / "c.h5");
    for (std::size_t size = 0; size < bytes.size(); size += size < 200 ? 1 : 97) {
        test::write_bytes(directory / "part.h5", bytes.substr(0, size));
        EXPECT_THROW((void)read_collection(directory / "part.h5"), InvalidInput) << size;
    }
}

TEST(CollectionFile, NeverGivesWrongValuesOfADamagedFile)
{
    const test::TemporaryDirectory directory;
    const Collection collection = bumpy_collection();
    write_collection(directory / "c.h5", collection);
    const std::string bytes = test::read_bytes(directory / "c.h5");
    Random random(4);
    int refused = 0;
    const auto open_files = [] {
        const std::filesystem::directory_iterator descriptors("/proc/self/fd");
        return std::distance(begin(descriptors), end(descriptors));
    };
    const auto open_before = open_files();
    for (int round = 0; round < 600; ++round) {
        std::string damaged = bytes;
        // Half of the flips hit the first 4 KiB, where most of the structure stands.
        const std::size_t reach = round % 2 == 0 ? bytes.size() : 4096;
        damaged[random.index(reach)] ^= static_cast<char>(1 << random.index(8));
        test::write_bytes(directory / "d.h5", damaged);
        try {
            expect_equal(read_collection(directory / "d.h5"), collection);
        } catch (const InvalidInput& error) {
            EXPECT_NE(std::string(error.what()).find("d.h5: "), std::string::npos) << error.what();
            ++refused;
        }
    }
    EXPECT_GT(refused, 300);
    EXPECT_EQ(open_files(), open_before);
}

TEST(CollectionFile, IsReadByH5py)
{
    if (test::python_with_h5py().empty())
        GTEST_SKIP() << "no Python with h5py";
    const test::TemporaryDirectory directory;
    const Collection collection = bumpy_collection();
    write_collection(directory / "c.h5", collection, {.derived = true});
    std::string points;
    for (const Points& mesh : collection.points)
        points.append(reinterpret_cast<const char*>(mesh.data()),
                      to_size(mesh.size()) * sizeof(double));
    test::write_bytes(directory / "points", points);
    EXPECT_EQ(test::run_h5py(
                  directory / "c.h5", "r",
                  "print(f['points'][...].tobytes() == open('" + (directory / "points").string() +
                      "', 'rb').read())\n"
                      "p, e, l = f['points'][...], f['topology/edges'][...], f['edge_lengths']\n"
                      "d = np.linalg.norm(p[:, e[:, 0]] - p[:, e[:, 1]], axis=2)\n"
                      "print(abs(d / l - 1).max() < 1e-12)\n"
                      "print(list(f['names'].asstr()))\n"
                      "print(list(f['labels/zeta'].asstr()), list(f['labels/alpha'].asstr()))\n"
                      "print(f.attrs['format'].decode(), f.attrs['format_version'])\n"
                      "print(sorted(f), f['topology/faces'].shape, f['topology/faces'].dtype,\n"
                      "      f['dihedral_angles'].shape, f['dihedral_angles'].dtype)\n"),
              "True\nTrue\n['bumpy 1', 'bumpy 2', 'bumpy 3', 'bumpy 4 Größe']\n"
              "['a', '', 'b', 'ä'] ['1', '2', '3', '4']\nlibshape collection 1\n"
              "['dihedral_angles', 'edge_lengths', 'labels', 'names', 'points', 'topology'] (80, "
              "3) int32 "
              "(4, 120) float64\n");
}

/// Replaces a dataset by another one.
std::string replaced(const std::string& name, const std::string& arguments)
{
    return "v = f['" + name + "'][...]; del f['" + name + "']; f.create_dataset('" + name + "', " +
           arguments + ")";
}

TEST(CollectionFile, NamesFileDatasetAndRuleOfWhatItRefuses)
{
    if (test::python_with_h5py().empty())
        GTEST_SKIP() << "no Python with h5py";
    const std::vector<test::BadEdit> cases = {
        {"f.attrs['format'] = np.bytes_('other')", "attribute format", "'libshape collection'"},
        {"f.attrs['format'] = np.bytes_('libshape model')", "attribute format", "'libshape model'"},
        {"f.attrs['format'] = 'text'", "attribute format", "fixed length"},
        {"f.attrs['format'] = 3", "attribute format", "fixed length"},
        {"del f.attrs['format']", "attribute format", "missing"},
        {"f.attrs['format_version'] = 2", "attribute format_version", "is 2"},
        {"f.attrs['format_version'] = 1.5", "attribute format_version", "integer"},
        {"f.attrs['format_version'] = [1, 1]", "attribute format_version", "single value"},
        {"del f['points']", "/points", "missing"},
        {"del f['topology']", "/topology/faces", "missing"},
        {"del f['points']; f.create_group('points')", "/points", "cannot be read"},
        // Types.
        {replaced("points", "data=v.astype('f4')"), "/points", "float64"},
        {replaced("points", "data=v.astype('>f8')"), "/points", "float64"},
        {replaced("points", "data=v.astype('i8')"), "/points", "float64"},
        {replaced("points", "data=v.astype('S8')"), "/points", "float64"},
        {replaced("topology/faces", "data=v.astype('i8')"), "/topology/faces", "int32"},
        {replaced("topology/faces", "data=v.astype('f8')"), "/topology/faces", "int32"},
        {replaced("points", "shape=v.shape, dtype=[('x', 'f8'), ('y', 'i4')]"), "/points",
         "float64"},
        {replaced("points", "shape=v.shape[:2], dtype=h5py.vlen_dtype('f8')"), "/points",
         "must be"},
        {replaced("names", "data=['a', 'b', 'c', 'd'], dtype=h5py.string_dtype()"), "/names",
         "fixed length"},
        {replaced("names", "data=[1, 2, 3, 4]"), "/names", "fixed length"},
        {replaced("names", "data=np.array([b'a', b'', b'c', b'd'])"), "/names", "has no name"},
        {replaced("names", "data=np.array([b'caf\\xe9', b'b', b'c', b'd'])"), "/names", "UTF-8"},
        {replaced("names", "shape=(4,), dtype='S5000'"), "/names", "5000 bytes"},
        // Shapes.
        {replaced("points", "data=v[:, :, :2]"), "/points",
         "is 4 by 42 by 2, must be any by any by 3"},
        {replaced("points", "data=v[0]"), "/points", "is 42 by 3"},
        {replaced("points", "data=v[None]"), "/points", "at most 3 dimensions"},
        {replaced("points", "data=1.0"), "/points", "is single value"},
        {replaced("points", "data=h5py.Empty('f8')"), "/points", "single value or an array"},
        {replaced("points", "data=v[:0]"), "/points", "no values"},
        {replaced("points", "data=v[:, :41]"), "/topology/faces", "names vertex 41"},
        {replaced("points", "data=v[:3]"), "/names", "is 4, must be 3"},
        {replaced("edge_lengths", "data=v[:, 1:]"), "/edge_lengths",
         "is 4 by 119, must be 4 by 120"},
        {replaced("edge_lengths", "data=v.T"), "/edge_lengths", "is 120 by 4"},
        {replaced("dihedral_angles", "data=v[:3]"), "/dihedral_angles", "is 3 by 120"},
        {replaced("labels/zeta", "data=v[:3]"), "/labels/zeta", "is 3, must be 4"},
        {replaced("topology/edges", "data=v[1:]"), "/topology/edges", "is 119 by 2"},
        // Sizes that a file cannot have.
        {replaced("points", "shape=(4, 2**40, 3), dtype='f8', chunks=(1, 1024, 3)"), "/points",
         "more than the file can hold"},
        {replaced("points", "shape=(2**62, 2**62, 3), dtype='f8', chunks=(1, 1, 3)"), "/points",
         "more than the file can hold"},
        {replaced("points", "shape=(2**30,), dtype='f8', chunks=(2**28,)"), "/points",
         "more than the file can hold"},
        {replaced("points", "data=v, chunks=(1, 42, 3), maxshape=(None, None, None)") +
             "; v = f['points'][...]; del f['points']; f.create_dataset('points', data=v[:1], "
             "chunks=(10**4, 10**4, 3), maxshape=(None, None, None)) if False else "
             "f.create_dataset('points', shape=v.shape, maxshape=(None, None, None), dtype='f8', "
             "chunks=(10**3, 10**4, 3))",
         "/points", "chunks of more than 67108864 bytes"},
        // Values that stand elsewhere, or need filters.
        {replaced("points", "data=v, compression='gzip'"), "/points", "without a checksum"},
        {replaced("points", "data=v, compression='gzip', shuffle=True"), "/points",
         "without a checksum"},
        {replaced("points", "data=v, shuffle=True"), "/points", "filter 2"},
        {replaced("points", "shape=v.shape, dtype='f8', external=[('/etc/passwd', 0, 4032)]"),
         "/points", "another file"},
        {"l = h5py.VirtualLayout(shape=(4, 42, 3), dtype='f8'); "
         "l[...] = h5py.VirtualSource('other.h5', 'points', shape=(4, 42, 3)); "
         "del f['points']; f.create_virtual_dataset('points', l)",
         "/points", "virtual"},
        {"del f['points']; f['points'] = h5py.ExternalLink('other.h5', '/points')", "/points",
         "link"},
        {"f['kept'] = f['points']; del f['points']; f['points'] = h5py.SoftLink('/kept')",
         "/points", "link"},
        {"del f['points']; f['points'] = h5py.SoftLink('/points')", "/points", "link"},
        {"f['t'] = f['topology']; del f['topology']; f['topology'] = h5py.SoftLink('/t')",
         "/topology/faces", "link"},
        {"f['labels/more'] = h5py.ExternalLink('other.h5', '/names')", "/labels/more", "link"},
        {"f.create_group('labels/more')", "/labels/more", "cannot be read"},
        // Values.
        {"f['points'][1, 2, 0] = np.nan", "/points", "value (1, 2, 0) is nan"},
        {"f['points'][3, 41, 2] = -np.inf", "/points", "value (3, 41, 2) is -inf"},
        {"f['edge_lengths'][2, 7] *= 1 + 1e-8", "/edge_lengths", "value (2, 7)"},
        {"f['edge_lengths'][0, 0] = -f['edge_lengths'][0, 0]", "/edge_lengths", "value (0, 0)"},
        {"f['points'][1] = 0; f['edge_lengths'][1] = 0", "/edge_lengths", "value (1, 0) is 0"},
        {"f['dihedral_angles'][0, 1] = np.nan", "/dihedral_angles", "value (0, 1) is nan"},
        {"f['topology/faces'][5, 1] = 42", "/topology/faces", "face 5 names vertex 42"},
        {"f['topology/faces'][5, 1] = -1", "/topology/faces", "face 5 names vertex -1"},
        {"f['topology/faces'][5] = f['topology/faces'][4]", "/topology/faces", "repeats face 4"},
        {"f['topology/faces'][5] = f['topology/faces'][5][::-1]", "/topology/faces", "flip one"},
        {"f['topology/edges'][3] = f['topology/edges'][4]", "/topology/edges", "row 3 is"},
        {"f['names'][1] = f['names'][0]", "/names", "'bumpy 1' occurs twice"},
    };
    const test::TemporaryDirectory directory;
    write_collection(directory / "c.h5", bumpy_collection(), {.derived = true});
    test::expect_refused(directory / "c.h5", cases,
                         [](const std::filesystem::path& file) { (void)read_collection(file); });
}

TEST(CollectionFile, RefusesAnEdgeWithoutLengthInAFileOfPositionsAlone)
{
    if (test::python_with_h5py().empty())
        GTEST_SKIP() << "no Python with h5py";
    const test::TemporaryDirectory directory;
    write_collection(directory / "c.h5", bumpy_collection());
    test::expect_refused(
        directory / "c.h5",
        {{"f['points'][1] = 0", "/points", "mesh 1 has an edge of length 0 (edge 0)"},
         {"v = f['points'][...]; del f['points']; f.create_dataset('points', data=v, "
          "compression='gzip', chunks=(1, 42, 3))",
          "/points", "without a checksum"},
         {"v = f['names'][...]; del f['names']; f.create_dataset('names', data=v, "
          "compression='gzip', fletcher32=True)",
          "/names", "filter 1"},
         {"v = f['names'][...]; del f['names']; f.create_dataset('names', data=v, "
          "compression='gzip')",
          "/names", "filter 1"}},
        [](const std::filesystem::path& file) { (void)read_collection(file); });
}

TEST(CollectionFile, IsReadFromDatasetsWithoutChunksAndWithoutLabels)
{
    if (test::python_with_h5py().empty())
        GTEST_SKIP() << "no Python with h5py";
    const test::TemporaryDirectory directory;
    Collection collection = bumpy_collection();
    write_collection(directory / "c.h5", collection);
    const auto files = test::edit_with_h5py(
        directory / "c.h5", {replaced("points", "data=v") + "; del f['labels']",
                             replaced("names", "data=v") + "; f['note'] = 'more does no harm'"});
    expect_equal(read_collection(files[1]), collection);
    collection.labels.clear();
    expect_equal(read_collection(files[0]), collection);
    const MeshStream stream = open_collection(files[0]);
    std::vector<Points> last(2, collection.points[0]);
    stream.fetch({1, 3})(last);
    EXPECT_EQ(last, (std::vector{collection.points[1], collection.points[3]}));
}

} // namespace
} // namespace shape
