// SPDX-License-Identifier: MIT

#include "libshape/io/collection_file.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cerrno>
#include <cmath>
#include <cstring>
#include <functional>
#include <numeric>
#include <utility>

#include "libshape/base/error.h"
#include "libshape/base/format.h"
#include "libshape/base/threads.h"
#include "libshape/base/to_size.h"
#include "libshape/io/collection_stream.h"
#include "libshape/io/file_parts.h"
#include "libshape/io/hdf5/handles.h"
#include "libshape/mesh/dihedral_angles.h"
#include "libshape/mesh/edge_lengths.h"

namespace shape {
using namespace internal;
namespace {

/// Runs body(i) for every mesh.
void for_each_mesh(std::size_t count, const std::function<void(Eigen::Index)>& body)
{
    parallel_for(count, 8, [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i)
            body(static_cast<Eigen::Index>(i));
    });
}

} // namespace

namespace {

/// The meshes of a stream one after the other, fetched some at a time.
class InOrder
{
public:
    explicit InOrder(const MeshStream& meshes)
        : meshes_(meshes),
          block_(std::clamp<Eigen::Index>(
              (Eigen::Index{16} << 20) /
                  (24 * static_cast<Eigen::Index>(meshes.topology.vertex_count())),
              1, 256))
    {
    }

    [[nodiscard]] const Points& operator[](Eigen::Index mesh)
    {
        if (mesh < first_ || mesh >= first_ + static_cast<Eigen::Index>(points_.size())) {
            std::vector<Eigen::Index> wanted(to_size(std::min(block_, meshes_.size() - mesh)));
            std::iota(wanted.begin(), wanted.end(), mesh);
            points_.resize(wanted.size(), Points(meshes_.topology.vertex_count(), 3));
            meshes_.fetch(std::move(wanted))(points_);
            first_ = mesh;
        }
        return points_[to_size(mesh - first_)];
    }

private:
    const MeshStream& meshes_;
    Eigen::Index block_;
    Eigen::Index first_ = 0;
    std::vector<Points> points_;
};

} // namespace

void write_collection(const std::filesystem::path& path, const Collection& collection,
                      const CollectionFileOptions& options)
{
    const MeshStream meshes = stream_of(collection);
    if (meshes.names.size() != collection.size())
        throw InvalidInput(join("/names: has ", meshes.names.size(), " values, must have ",
                                collection.size(), " and at least 1"));
    write_collection(path, meshes, options);
}

void write_collection(const std::filesystem::path& path, const MeshStream& meshes,
                      const CollectionFileOptions& options, const Progress& progress)
{
    const Topology& topology = meshes.topology;
    const Eigen::Index count = meshes.size();
    Hdf5Content content = begin_content(FileKind::Collection);
    add_topology(content, topology);
    InOrder in_order(meshes);
    // One mesh at a time: together they would take as much memory as the file.
    const auto add = [&](const char* name, Extents extents, const auto& measure) {
        content.datasets.push_back(
            {name, std::move(extents),
             Hdf5Rows([&in_order, measure](Eigen::Index i, std::span<double> numbers) {
                 const Eigen::VectorXd values = measure(i, in_order[i]);
                 std::copy(values.begin(), values.end(), numbers.begin());
             }),
             options.compress});
    };
    add("/points", {count, topology.vertex_count(), 3}, [&](Eigen::Index i, const Points& points) {
        if (!points.allFinite() || !(edge_lengths(topology, points).minCoeff() > 0.0))
            throw InvalidInput(join("mesh ", i,
                                    " of the collection has a coordinate that is not "
                                    "finite or an edge of length 0"));
        if (progress)
            progress("writing", to_size(i) + 1, to_size(count));
        return Eigen::VectorXd(points.reshaped<Eigen::RowMajor>());
    });
    if (options.derived) {
        add("/edge_lengths", {count, topology.edge_count()},
            [&](Eigen::Index, const Points& points) { return edge_lengths(topology, points); });
        add("/dihedral_angles", {count, topology.edge_count()},
            [&](Eigen::Index, const Points& points) { return dihedral_angles(topology, points); });
    }
    add_names(content, count, meshes.names);
    add_labels(content, count, meshes.labels);
    write_hdf5(path, content);
}

namespace {

/// The file that is appended to, as it was when it was opened, and where the new one is written.
class ReplacedFile
{
public:
    explicit ReplacedFile(const std::filesystem::path& path)
        : path_(path), folder_(path.has_parent_path() ? path.parent_path() : ".")
    {
        static std::atomic<unsigned> counter{0};
        beside_ = path.parent_path() / join(".shape-", ::getpid(), "-append-", counter++, ".tmp");
        // While it is open, no other file gets its inode.
        descriptor_ = ::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK | O_NOFOLLOW);
        if (descriptor_ < 0)
            fail(errno == ELOOP ? "is a symbolic link; name the file it points to"
                                : std::strerror(errno));
        if (::fstat(descriptor_, &status_) != 0) {
            const int error = errno;
            ::close(descriptor_);
            fail(std::strerror(error));
        }
    }
    ~ReplacedFile()
    {
        if (!is_replaced_)
            ::unlink(beside_.c_str());
        ::close(descriptor_);
    }
    ReplacedFile(const ReplacedFile&) = delete;
    ReplacedFile& operator=(const ReplacedFile&) = delete;

    [[nodiscard]] const std::filesystem::path& beside() const { return beside_; }

    /// Renames the new file into place, unless the old one has been replaced or written to.
    void replace()
    {
        const Lock lock(folder_);
        struct stat now = {};
        if (::lstat(path_.c_str(), &now) != 0 || !is_as_it_was(now))
            throw FileError(
                join(path_.string(),
                     " changed while meshes were appended to it; run the command again"));
        if (::rename(beside_.c_str(), path_.c_str()) != 0)
            fail(std::strerror(errno));
        is_replaced_ = true;
    }

private:
    /// Of two that look and rename at once one waits, and then finds another file. A lock of the folder,
    /// for other programs lock HDF5 files while they read them. Where the file system has no locks, or a
    /// stranger has this one, the moment between looking and renaming is left.
    class Lock
    {
    public:
        explicit Lock(const std::filesystem::path& folder)
            : descriptor_(::open(folder.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC))
        {
            for (int attempt = 0; attempt < 100; ++attempt) {
                if (::flock(descriptor_, LOCK_EX | LOCK_NB) == 0 || errno != EWOULDBLOCK)
                    break;
                ::usleep(10000);
            }
        }
        ~Lock()
        {
            (void)::fsync(descriptor_); // some file systems cannot; the new file is in place
            ::close(descriptor_);
        }
        Lock(const Lock&) = delete;
        Lock& operator=(const Lock&) = delete;

    private:
        int descriptor_;
    };

    [[noreturn]] void fail(const std::string& cause) const
    {
        throw FileError(join("cannot write ", path_.string(), ": ", cause));
    }

    [[nodiscard]] bool is_as_it_was(const struct stat& now) const
    {
        return now.st_dev == status_.st_dev && now.st_ino == status_.st_ino &&
               now.st_size == status_.st_size && now.st_mtim.tv_sec == status_.st_mtim.tv_sec &&
               now.st_mtim.tv_nsec == status_.st_mtim.tv_nsec;
    }

    std::filesystem::path path_;
    std::filesystem::path folder_;
    std::filesystem::path beside_;
    struct stat status_ = {};
    int descriptor_ = -1;
    bool is_replaced_ = false;
};

/// With which options a file was written that has been read without an error.
CollectionFileOptions options_of(const std::filesystem::path& path)
{
    const Hdf5File file(path);
    const Silence silence;
    try {
        const Id opened = open_file(path);
        const Id points(H5Dopen2(opened, "/points", H5P_DEFAULT), H5Dclose);
        const Id creation(H5Dget_create_plist(points), H5Pclose);
        bool is_packed = false;
        for (int i = 0; i < checked(H5Pget_nfilters(creation)); ++i) {
            unsigned flags = 0;
            std::size_t none = 0;
            is_packed = is_packed ||
                        checked(H5Pget_filter2(creation, static_cast<unsigned>(i), &flags, &none,
                                               nullptr, 0, nullptr, nullptr)) == H5Z_FILTER_DEFLATE;
        }
        return {.derived = file.has("/edge_lengths") || file.has("/dihedral_angles"),
                .compress = is_packed};
    } catch (const Hdf5Failure& failure) {
        throw InvalidInput(
            join(path.string(), ": the HDF5 file is truncated or damaged (", failure.what(), ")"));
    }
}

} // namespace

Eigen::Index append_to_collection(const std::filesystem::path& path, const MeshStream& added,
                                  const CollectionFileOptions& options, const Progress& progress)
{
    ReplacedFile file(path);
    const MeshStream all = joined(open_collection(path), added);
    CollectionFileOptions kept = options_of(path);
    kept.derived = kept.derived || options.derived;
    kept.compress = kept.compress || options.compress;
    try {
        write_collection(file.beside(), all, kept, progress);
    } catch (const FileError& error) {
        // People know nothing of the file beside.
        std::string said = error.what();
        const std::string name = file.beside().string();
        if (const std::size_t place = said.find(name); place != std::string::npos)
            said.replace(place, name.size(), path.string());
        throw FileError(said);
    }
    file.replace();
    return all.size();
}

Collection read_collection(const std::filesystem::path& path)
{
    const Hdf5File file(path);
    check_kind(file, FileKind::Collection);
    RowMatrix points = file.numbers("/points", {any_length, any_length, 3});
    const Eigen::Index count = points.rows();
    const Eigen::Index vertex_count = points.cols() / 3;
    Collection collection{
        read_topology(file, vertex_count), read_names(file, count), {}, read_labels(file, count)};
    const Topology& topology = collection.topology;
    // One dataset at a time in memory beside the meshes.
    collection.points.resize(to_size(count));
    for_each_mesh(collection.size(), [&](Eigen::Index i) {
        collection.points[to_size(i)] =
            Eigen::Map<const Points>(points.row(i).data(), vertex_count, 3);
    });
    points.resize(0, 0);
    if (file.has("/edge_lengths")) {
        const RowMatrix lengths = file.numbers("/edge_lengths", {count, topology.edge_count()});
        for_each_mesh(collection.size(), [&](Eigen::Index i) {
            const Eigen::VectorXd measured = edge_lengths(topology, collection.points[to_size(i)]);
            for (Eigen::Index e = 0; e < measured.size(); ++e)
                if (!(measured[e] > 0.0) ||
                    !(std::abs(lengths(i, e) - measured[e]) <= 1e-9 * measured[e]))
                    file.fail("/edge_lengths", join("value (", i, ", ", e, ") is ", lengths(i, e),
                                                    ", must be > 0 and the distance ", measured[e],
                                                    " of the points"));
        });
    } else {
        for_each_mesh(collection.size(), [&](Eigen::Index i) {
            Eigen::Index edge = 0;
            if (!(edge_lengths(topology, collection.points[to_size(i)]).minCoeff(&edge) > 0.0))
                file.fail("/points",
                          join("mesh ", i, " has an edge of length 0 (edge ", edge, ")"));
        });
    }
    if (!file.has("/dihedral_angles"))
        return collection;
    const RowMatrix angles = file.numbers("/dihedral_angles", {count, topology.edge_count()});
    for_each_mesh(collection.size(), [&](Eigen::Index i) {
        const Eigen::VectorXd measured = dihedral_angles(topology, collection.points[to_size(i)]);
        for (Eigen::Index e = 0; e < measured.size(); ++e)
            if (!(std::abs(wrapped_angle(angles(i, e) - measured[e])) <= 1e-6))
                file.fail("/dihedral_angles",
                          join("value (", i, ", ", e, ") is ", angles(i, e),
                               ", the points and /topology/faces give ", measured[e]));
    });
    return collection;
}

} // namespace shape
